"""What is free for arm, tool and sight in a cell, and which configurations can be measured there."""
