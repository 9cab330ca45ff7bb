"""What the format leaves open in a table of legs is read as it means."""

from truepose.exchange.tables.ballbar import read_leg_table
from truepose.messages.catalogue import english

HEADER = "placement,config,q1_deg,repeat_of,base_point,tool_point,length_mm,u_mm"


def read(*rows):
    return read_leg_table("legs.csv", "\n".join([HEADER, *rows]).encode(), 1, range(1, 4))


def test_stops_that_each_placement_counts_for_itself_are_kept_apart_and_that_is_said():
    legs, said = read(
        "1,1,10,,1,1,300.1,0.001",
        "1,12,20,1,1,1,300.2,0.001",
        "2,1,30,,1,1,300.3,0.001",
        "2,3,40,1,1,1,300.4,0.001",
    )

    assert legs.stops.config.tolist() == [1, 12, 101, 103]
    assert legs.stops.repeat_of.tolist() == [-1, 1, -1, 101]  # of the stop of its own placement
    (sentence,) = said
    assert "100 is added" in english(sentence)


def test_numbers_that_no_two_placements_share_stay_as_they_are():
    legs, said = read("1,1,10,,1,1,300.1,0.001", "2,2,30,,1,1,300.3,0.001", "1,1,10,,1,2,300.2,0.001")

    assert legs.stops.config.tolist() == [1, 2, 1]
    assert said == ()
