"""A drawing that is repeated: painted once while its key stays, and drawn the same each time."""

from types import SimpleNamespace

from lensbench.app.drawing import recorded, theme


class Listed:
    """A draw list that notes what it is asked to draw."""

    def __init__(self):
        self.drawn = []

    def add_line(self, *args):
        self.drawn.append(args)


def test_a_drawing_is_painted_once_for_each_key_and_look(monkeypatch):
    looks = SimpleNamespace(now=(True, 1.0, 14.0))
    monkeypatch.setattr(theme, "look", lambda: looks.now)
    painted, drawing = [], recorded.Recorded()

    def frame(key):
        def paint(draw):
            painted.append(key)
            draw.add_line(key, 1.0)
            draw.add_line(key, 2.0)

        into = Listed()
        drawing.draw(into, key, paint)
        return into.drawn

    assert frame("a") == frame("a") == [("a", 1.0), ("a", 2.0)]
    assert painted == ["a"]
    assert frame("b") == [("b", 1.0), ("b", 2.0)]
    looks.now = (False, 1.0, 14.0)
    frame("b")
    assert painted == ["a", "b", "b"]
