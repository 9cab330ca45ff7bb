"""Neighbours of an SVG that look the same, as one path."""

import re

from truepose.reports.figures.svg_rendering import joined_shapes

ROUND = 'd="M 0 1.5 \nC 0.4 1.5 0.8 1.3 1.1 1.1 \nz\n"'
DIAMOND = 'd="M 0 -2 \nL 2 0 \nL 0 2 \nL -2 0 \nz\n"'


def drawn(marker, *uses):
    return f'<svg><defs>\n<path id="m" {marker}/>\n</defs>\n<g>\n' + "\n".join(uses) + "\n</g></svg>"


def dot(x, y, look='fill="red"'):
    return f'<use xlink:href="#m" x="{x}" y="{y}" {look}/>'


def test_dots_of_one_look_are_one_path_as_wide_as_each_was():
    svg = joined_shapes(drawn(ROUND, dot(10, 20), dot(30, 40), dot(50, 60)))

    assert "<use" not in svg
    assert 'd="M10.00 20.00h0 M30.00 40.00h0 M50.00 60.00h0"' in svg
    assert 'stroke="red" stroke-linecap="round" stroke-width="3"' in svg


def test_the_edge_of_a_dot_and_its_opacity_are_kept():
    look = 'fill="red" fill-opacity="0.4" stroke="red" stroke-width="0.5"'

    svg = joined_shapes(drawn(ROUND, dot(1, 2, look), dot(3, 4, look)))

    assert 'stroke-width="3.5"' in svg
    assert 'stroke-opacity="0.4"' in svg


def test_other_markers_keep_their_outline_where_they_stand():
    svg = joined_shapes(drawn(DIAMOND, dot(10, 20), dot(30, 40)))

    assert "M 10.00 18.00 L 12.00 20.00" in svg
    assert "M 30.00 38.00" in svg


def test_another_look_is_another_path():
    svg = joined_shapes(drawn(ROUND, dot(1, 2), dot(3, 4), dot(5, 6, 'fill="blue"')))

    assert len(re.findall(r"<path d=", svg)) == 2


def test_what_stands_alone_is_left_alone():
    alone = drawn(ROUND, dot(1, 2), "<text>3</text>", dot(5, 6))

    assert joined_shapes(alone) == alone
