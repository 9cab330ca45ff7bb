"""What this program cannot do about a motion that has begun, said to whoever lets it begin or end."""

from truepose_drivers.api import GuardsMotion, MotionGuard


def end_of_motion(controller: GuardsMotion) -> str:
    """Return when the arm comes to rest after a pause or the end was asked for, as the end of a sentence."""
    longest_s = controller.motion_guard.longest_piece_s
    if longest_s is None:
        return "a motion under way cannot be stopped through this program, so it ends first"
    return (
        "a motion under way cannot be stopped through this program, so the piece of it that was sent ends "
        f"first, within about {longest_s:g} s"
    )


def motion_notice(guard: MotionGuard) -> str:
    """Return what whoever lets the arm move has to know of this controller, in a sentence or two."""
    if guard.stops_unheard_s is not None:
        alone = f"the controller stops the arm by itself within {guard.stops_unheard_s:g} s"
    elif guard.longest_piece_s is not None:
        alone = (
            f"the arm goes on for up to {guard.longest_piece_s:g} s, to the end of the piece that was sent"
        )
    else:
        alone = "the arm goes on to the target that was sent"
    return (
        f"If this program or its connection fails while the arm moves, {alone}. "
        "Only the emergency stop stops the arm at once."
    )
