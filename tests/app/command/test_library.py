"""`lensbench lenses`: the library as a table and as JSON, searched, filtered and sorted."""

import json

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.command.main import main


def listed(capsys, *options):
    """Names of the lenses that the command prints, the same in both forms."""
    assert main(["lenses", *options]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert main(["lenses", *options, "--json"]) == 0
    names = [card["name"] for card in json.loads(capsys.readouterr().out)]
    assert [line.split()[0] for line in lines[1:]] == names or not names
    return names


def test_the_library_is_listed_whole(capsys):
    assert listed(capsys) == lenses.names()


def test_json_has_the_whole_card(capsys):
    assert main(["lenses", "--search", "noct", "--json"]) == 0
    card = json.loads(capsys.readouterr().out)[0]
    assert card["name"] == "lv-nikon-z-58f095-noct" and card["film_size"] == [36.0, 24.0]
    assert (card["maker"], card["patent"], card["elements"], card["groups"], card["zooms"]) == (
        "Nikon", "WO 2019/229849", 17, 10, False)


def test_options_filter_sort_and_search(capsys):
    cards = {card.name: card for card in lenses.describe()}
    macros = listed(capsys, "--kind", "macro", "--maker", "nikon", "--faster", "f/2.8", "--sort", "focal")
    assert macros and all(cards[name].kind == "macro" and cards[name].maker == "Nikon" for name in macros)
    lengths = [cards[name].efl for name in listed(capsys, "--focal", "85-135", "--year", "1950-1970", "--prime",
                                                  "--sort", "focal")]
    assert lengths and lengths == sorted(lengths) and all(85.0 <= length <= 135.0 for length in lengths)
    assert all(cards[name].year <= 1930 for name in listed(capsys, "--year", "-1930"))
    assert all(cards[name].zooms and cards[name].aspheres for name in listed(capsys, "--zoom", "--asphere"))
    assert all(cards[name].film_size == (36.0, 24.0) for name in listed(capsys, "--format", "full frame"))
    assert "lentil-zeiss-biotar-1927" in listed(capsys, "--focal", "50", "--maker", "zeiss")
    assert listed(capsys, "--search", "sonnar 1931")[0] == "lib-bertele-sonnar-1998704a"


def test_no_match_is_said(capsys):
    assert main(["lenses", "--maker", "zeiss", "--focal", "1000-"]) == 0
    assert "No lens of the" in capsys.readouterr().out


@pytest.mark.parametrize(("options", "reason"), [
    (["--kind", "makro"], "did you mean macro"), (["--maker", "nobody at all"], "there are"),
    (["--focal", "90-80"], "smaller"), (["--focal", "-"], "not a range"), (["--faster", "fast"], "positive number"),
    (["--format", "vhs"], "full frame"), (["--zoom", "--prime"], "not allowed with"), (["--sort", "price"], "choose")])
def test_a_filter_that_cannot_be_met_is_an_error_of_one_line(capsys, options, reason):
    assert main(["lenses", *options]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and reason in error


def test_every_scene_is_listed_in_a_line_with_its_framings_as_data(capsys):
    assert main(["scenes"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert [row.split()[0] for row in rows] == list(lb.SCENES) and min(map(len, rows)) > 40
    assert main(["scenes", "--json"]) == 0
    listed = {row["name"]: row["framings"] for row in json.loads(capsys.readouterr().out)}
    assert "head" in listed["portrait"] and "head" not in listed["room"]
