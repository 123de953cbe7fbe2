"""The kept hash of a frozen value: that of its fields, computed once, and never carried into another process."""

import pickle
from dataclasses import dataclass, replace

import lensbench as lb
from lensbench.core.lazy import hashed_once


class Counted(str):
    """A text that counts how often it is hashed."""

    hashed = 0

    def __hash__(self):
        Counted.hashed += 1
        return super().__hash__()


@hashed_once
@dataclass(frozen=True)
class Value:
    name: str
    size: float = 1.0


def test_equal_values_have_one_hash_which_is_computed_once_for_each():
    one, same, other = Value(Counted("a")), Value("a"), Value("b")
    before = Counted.hashed
    assert hash(one) == hash(one) == hash(same) != hash(other)
    assert Counted.hashed - before == 1
    assert {one: 1}[same] == 1 and one == same


def test_neither_a_changed_value_nor_one_in_another_process_inherits_the_hash():
    one = Value("a")
    hash(one)
    assert hash(replace(one, size=2.0)) != hash(one)
    sent = pickle.loads(pickle.dumps(one))
    assert "_hash" not in vars(sent) and sent == one


def test_a_scene_is_hashed_once_however_often_a_cache_asks_for_it():
    mesh = lb.Mesh.of([(0, 0, -1), (1, 0, -1), (0, 1, -1)], [(0, 1, 2)], name=Counted("mesh"))
    scene, again = (lb.Scene(Counted("scene"), spheres=(lb.Sphere((0, 0, -9), 1, lb.Material((1.0,) * 3)),),
                             meshes=(mesh,)) for _ in range(2))
    before = Counted.hashed
    assert hash(scene) == hash(scene) == hash(again) and scene == again
    assert Counted.hashed - before == 3                 # two scenes of one mesh
    assert "_hash" not in vars(pickle.loads(pickle.dumps(scene)))
