"""Make these sharp, with real clicks: two points tilt the film, a third turns it on, undo takes each back."""

from dataclasses import replace

from tests.app.conftest import SMALL


def test_clicks_in_the_picture_tilt_the_film_and_undo_takes_them_back(drive):
    def use(hand):
        view = hand.session.view
        hand.picture()
        before = hand.settings
        hand.ctx.item_click("**/Sharp pick")
        assert view.sharp_pick and not view.focus_pick

        def click(x, y, count):
            hand.ctx.mouse_move_to_pos(hand.at("**/Picture", x, y))
            hand.ctx.mouse_click(0)
            hand.wait(lambda: view.picks is not None and len(view.picks.points) == count, f"point {count}")
            hand.picture()

        click(0.45, 0.72, 1)
        assert hand.settings == before
        click(0.35, 0.45, 2)
        two = hand.settings
        assert (two.tilt, two.swing) != (0.0, 0.0) and two.focus_distance != before.focus_distance
        click(0.65, 0.72, 3)
        assert (hand.settings.tilt, hand.settings.swing) != (two.tilt, two.swing)
        hand.ctx.menu_click("//##MainMenuBar/Edit/Undo")
        hand.ctx.yield_(2)
        assert hand.settings == two
        hand.ctx.menu_click("//##MainMenuBar/Edit/Undo")
        hand.ctx.yield_(2)
        assert hand.settings == before
        hand.ctx.item_click("**/Sharp pick")
        assert not view.sharp_pick and view.focus_pick and view.picks is None

    assert drive(use, replace(SMALL, f_number=2.8)).view.messages == []
