"""Zoom and focus positions: thin groups by their closed form, what follows when a lens moves, what cannot be."""

from dataclasses import replace
from math import inf, nan

import pytest
from hypothesis import given, strategies as st

import lensbench as lb
from tests.core.oracles import LAW, biconvex

F1, F2 = -80.0, 40.0                # focal lengths of the two groups (mm)
SEPARATIONS = (50.0, 24.0, 8.0)     # wide, middle, tele
THIN = 1e-9                         # mm: of an element


def thin(focal_length, gap, index=1.5, rim=8.0):
    """Two surfaces, nothing between them, of this focal length."""
    c = 0.5 / (focal_length * (index - 1.0))
    return lb.Surface(THIN, rim, lb.Glass(index), curvature=c), lb.Surface(gap, rim, curvature=-c)


def two_group_efl(d):
    return 1.0 / (1.0 / F1 + 1.0 / F2 - d / (F1 * F2))


def two_group_bfl(d):
    return F2 * (F1 - d) / (F1 + F2 - d)


def zoom(**more) -> lb.Lens:
    """Two thin groups: the first gap and the back focus vary, three zoom stations at infinity."""
    stations = tuple(((d, two_group_bfl(d)),) for d in SEPARATIONS)
    lens = lb.Lens((*thin(F1, SEPARATIONS[0]), *thin(F2, two_group_bfl(SEPARATIONS[0]))), 2)
    positions = lb.Positions((1, 3), tuple(stations), (0.0, 0.4, 1.0), **more)
    return replace(lens, positions=positions).at()


@pytest.mark.parametrize(("place", "d"), [(0.0, 50.0), (0.4, 24.0), (1.0, 8.0)])
def test_two_thin_groups_have_the_focal_length_of_their_separation(place, d):
    at = zoom().at(zoom=place)
    fo = lb.first_order(at)
    assert [s.thickness for s in at.surfaces] == [THIN, d, THIN, two_group_bfl(d)]
    # a thin element of 1e-9 mm moves the foci by that much
    assert fo.efl == pytest.approx(two_group_efl(d), rel=1e-9)
    assert fo.bfl == pytest.approx(at.surfaces[-1].thickness, rel=1e-9)


@LAW
@given(st.floats(0.0, 1.0))
def test_between_stations_the_gaps_and_the_focal_length_lie_between_theirs(place):
    at = zoom().at(zoom=place)
    gap = at.surfaces[1].thickness
    wider = 0 if place <= 0.4 else 1
    assert SEPARATIONS[wider + 1] <= gap <= SEPARATIONS[wider]
    assert lb.first_order(at).efl == pytest.approx(two_group_efl(gap), rel=1e-9)


@LAW
@given(st.floats(0.0, 1.0), st.floats(0.2, 5.0))
def test_moving_and_scaling_a_lens_are_the_same_in_either_order(place, factor):
    lens = zoom(focal_lengths=tuple(map(two_group_efl, SEPARATIONS)))
    one, other = lens.at(zoom=place).scaled(factor), lens.scaled(factor).at(zoom=place)
    for a, b in zip(one.surfaces, other.surfaces, strict=True):
        assert (a.curvature, a.semi_diameter) == (b.curvature, b.semi_diameter)
        assert a.thickness == pytest.approx(b.thickness, rel=1e-14)
    assert one.stated_efl == pytest.approx(other.stated_efl, rel=1e-14)
    assert one.positions == other.positions


def test_moving_a_lens_there_and_back_restores_it():
    lens = zoom(focal_lengths=(30.0, 40.0, 50.0), f_numbers=(2.8, 3.5, 4.0), stops=((8.0,), (7.0,), (6.5,)))
    assert lens.at(zoom=1.0) != lens == lens.at(zoom=0.7).at(zoom=0.0)
    tele = lens.at(zoom=1.0)
    assert (tele.stated_efl, tele.stated_f_number, tele.stop.semi_diameter) == (50.0, 4.0, 6.5)
    assert tele.at() == tele and tele.at(close=0.0) == tele


def test_stopping_down_holds_at_every_position():
    lens = zoom(stops=((8.0,), (7.0,), (6.5,)))
    half = lens.with_stop_radius(4.0)
    assert [half.at(zoom=z).stop.semi_diameter for z in (0.0, 0.4, 1.0)] == [4.0, 3.5, 3.25]
    wide = lb.first_order(lens).f_number
    assert lb.first_order(lb.stopped_down(lens, 2.0 * wide)).f_number == pytest.approx(2.0 * wide, rel=1e-12)
    fixed = zoom().with_stop_radius(3.0)
    assert fixed.at(zoom=1.0).stop.semi_diameter == 3.0


@pytest.mark.parametrize(("asked", "told"), [
    ({"zoom": 0.5}, "does not zoom: zoom must be 0"), ({"close": 1.0}, "close must be 0"), ({"zoom": nan}, "zoom"),
])
def test_a_lens_without_positions_stays_where_it_is(asked, told):
    lens = biconvex()
    assert lens.at(zoom=0.0, close=0.0) == lens.at() == lens and not lens.zooms and not lens.has_focus_groups
    with pytest.raises(lb.LensError, match=told):
        lens.at(**asked)


@pytest.mark.parametrize("asked", [{"zoom": 1.01}, {"zoom": -0.1}, {"zoom": nan}, {"close": 0.1}])
def test_a_position_beyond_the_stations_is_refused(asked):
    with pytest.raises(lb.LensError, match="it must lie between|close must be 0"):
        zoom().at(**asked)


@pytest.mark.parametrize(("changed", "told"), [
    ({"zoom_stations": (0.0, 1.0)}, "thicknesses must have a row"),
    ({"zoom_stations": (0.0, 0.9, 0.8, 1.0)}, "must rise from 0 to 1"),
    ({"zoom_stations": (0.0, 1.0, 1.0)}, "must rise from 0 to 1"),
    ({"zoom_stations": (0.1, 0.5, 1.0)}, "must rise from 0 to 1"),
    ({"focus_stations": (0.0, 1.0)}, "thicknesses must have a row"),
    ({"focus_stations": ()}, "must rise from 0 to 1"),
    ({"gaps": (3, 1)}, "in rising order"), ({"gaps": ()}, "in rising order"), ({"gaps": (1,)}, "must have 1 gaps"),
    ({"names": ("wide",)}, "names has 1 values for 3"),
    ({"focal_lengths": (1.0, inf, 2.0)}, "finite"), ({"stops": ((1.0,), (0.0,), (2.0,))}, "positive"),
    ({"distances": ((inf,), (-1.0,), (inf,))}, "not positive"),
    ({"thicknesses": (((1.0, nan),), ((1.0, 2.0),), ((1.0, 2.0),))}, "finite"),
    ({"close": 0.5}, "more than one station"), ({"zoom": 2.0}, "between 0"),
])
def test_an_invalid_table_is_refused_with_a_reason(changed, told):
    positions = zoom().positions
    with pytest.raises(lb.PositionsError, match=told):
        replace(positions, **changed)


def test_a_gap_behind_a_surface_that_is_not_there_is_refused():
    with pytest.raises(lb.LensError, match="this lens has surfaces 0 to 1"):
        replace(biconvex(), positions=zoom().positions)


def test_stations_are_called_by_their_name_their_focal_length_or_their_end():
    positions = zoom().positions
    assert [positions.label(i) for i in range(3)] == ["wide", "zoom 0.4", "tele"]
    assert replace(positions, focal_lengths=(24.0, 35.0, 70.0)).label(1) == "35 mm"
    assert replace(positions, names=("W", "M", "T"), focal_lengths=(24.0, 35.0, 70.0)).label(2) == "T"
    row = tuple(row * 3 for row in positions.thicknesses)
    assert replace(positions, thicknesses=row, focus_stations=(0.0, 0.5, 1.0)).label(2, 1) == "tele, close 0.5"


# Focusing by groups

FOCUS_SHIFT = 6.0


def inner_focus(**more) -> lb.Lens:
    """The same zoom; to focus, its rear group moves by up to 6 mm towards the scene while the film stays."""
    gaps = tuple(((d, two_group_bfl(d)), (d - FOCUS_SHIFT, two_group_bfl(d) + FOCUS_SHIFT)) for d in SEPARATIONS)
    lens = zoom()
    return replace(lens, positions=lb.Positions((1, 3), gaps, (0.0, 0.4, 1.0), (0.0, 1.0), **more)).at()


def thin_image(focal_length, distance):
    """1/f = 1/s + 1/s′."""
    return 1.0 / (1.0 / focal_length - 1.0 / distance)


@LAW
@given(st.sampled_from([0.0, 0.4, 1.0]), st.floats(1.0, 100.0))
def test_the_groups_stand_where_two_thin_lenses_put_the_image_on_the_film(place, times_nearest):
    lens = inner_focus().at(zoom=place)
    distance = times_nearest * lb.nearest_focus(lens)
    moved = lb.focused(lens, distance)
    film = lb.film_distance(lens, distance)
    separation = moved.surfaces[1].thickness
    first = thin_image(F1, distance - separation - film)
    assert thin_image(F2, separation - first) == pytest.approx(film, abs=1e-7)      # the thickness of the elements
    assert film == pytest.approx(moved.surfaces[-1].thickness, abs=1e-7)
    assert moved.length + film == pytest.approx(lens.length + lens.surfaces[-1].thickness, abs=1e-7)     # it stays


@LAW
@given(st.floats(0.0, 1.0), st.floats(1.0, 1000.0), st.sampled_from([1.0, 1.333]))
def test_focused_distance_inverts_film_distance_at_every_zoom_setting(place, times_nearest, in_front):
    lens = replace(inner_focus(), front_index=in_front).at(zoom=place)
    distance = times_nearest * lb.nearest_focus(lens)
    moved, film = lb.focused(lens, distance), lb.film_distance(lens, distance)
    # the film's own rounding, 1e-12 mm, moves the object by (distance / f)² times as much
    assert lb.focused_distance(moved, film) == pytest.approx(distance, rel=1e-9 + 1e-15 * distance)
    assert lb.focused(moved, distance) == moved and lb.film_distance(moved, distance) == film
    assert moved.positions.zoom == place


def test_infinity_is_sharp_at_every_zoom_setting_and_the_nearest_is_the_last_station():
    for place in (0.0, 0.17, 0.4, 0.8, 1.0):
        lens = inner_focus().at(zoom=place)
        assert lb.focused(lens, inf) == lens
        assert lb.film_distance(lens, inf) == pytest.approx(lb.first_order(lens).bfl, abs=1e-13)
        nearest = lb.nearest_focus(lens)
        assert lb.focused(lens, nearest).positions.close == pytest.approx(1.0, abs=1e-9)
        assert lb.nearest_focus(lb.focused(lens, 2.0 * nearest)) == nearest


@pytest.mark.parametrize("method", ["paraxial", "real"])
def test_beyond_the_groups_reach_the_error_names_a_distance_that_can_be_had(method):
    lens = inner_focus().at(zoom=0.3).with_stop_radius(1.0)
    with pytest.raises(lb.FocusError, match=r"the nearest distance of this lens is 0\.\d+ m") as caught:
        lb.film_distance(lens, 90.0, method)
    metres = float(str(caught.value).split("lens is ")[1].split(" m")[0])
    assert lb.film_distance(lens, 1000.0 * metres, method) > 0.0
    for distance in (nan, 0.0, -1.0):
        with pytest.raises(lb.FocusError, match="nearest distance"):
            lb.film_distance(lens, distance, method)


def test_the_real_focus_tends_to_the_paraxial_one_as_the_stop_closes():
    lens = inner_focus().at(zoom=0.6)
    for distance in (lb.nearest_focus(lens) * 1.2, 3000.0):
        paraxial = lb.focused(lens, distance).positions.close
        errors = [abs(lb.focused(lens.with_stop_radius(r), distance, "real").positions.close - paraxial)
                  for r in (2.0, 1.0)]
        assert errors[0] < 0.05 and errors[1] == pytest.approx(errors[0] / 4.0, rel=0.1)       # as the height squared


def test_groups_that_do_not_focus_nearer_say_so():
    lens = inner_focus()
    gaps = tuple(((d, b), (d, b)) for ((d, b), _) in lens.positions.thicknesses)
    still = replace(lens, positions=replace(lens.positions, thicknesses=gaps))
    assert lb.nearest_focus(still) == inf and lb.film_distance(still, inf) > 0.0
    with pytest.raises(lb.FocusError, match="its focus groups reach no nearer object"):
        lb.film_distance(still, 2000.0)


def test_a_camera_moves_the_groups_and_keeps_the_zoom():
    lens = inner_focus().at(zoom=1.0)
    film = lb.Film(width=12.0, height=8.0, pixels_x=12, pixels_y=8)
    camera = lb.LensCamera(lens, film, focus_distance=6000.0, f_number=8.0)
    assert camera.film_distance == lb.film_distance(lens, 6000.0)
    assert camera.lens.surfaces[1].thickness == lb.focused(lens, 6000.0).surfaces[1].thickness < SEPARATIONS[2]
    again = replace(camera, focus_distance=inf, f_number=None)
    assert again.lens.surfaces[1].thickness == SEPARATIONS[2]
    # the middle of the film and the middle of the pupil look along the axis, at 6 m
    rays = camera.generate_rays([[6.0, 4.0]], [[0.5, 0.5]], [0.0])
    assert abs(rays.directions[0, :2]).max() < 1e-3
    with pytest.raises(lb.FocusError, match="nearest distance"):
        replace(camera, focus_distance=50.0)
