"""All kinds of records side by side: searched, listed, and how one came of another."""
