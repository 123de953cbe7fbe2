"""The kept hash of a frozen value: that of its fields, computed once, and never carried into another process."""

import pickle
from dataclasses import dataclass, replace

from lensbench.kernels.hashed import hashed_once


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
    assert hash(one) == hash(one) == hash(same) != hash(other)
    assert Counted.hashed == 1
    assert {one: 1}[same] == 1 and one == same


def test_neither_a_changed_value_nor_one_in_another_process_inherits_the_hash():
    one = Value("a")
    hash(one)
    assert hash(replace(one, size=2.0)) != hash(one)
    sent = pickle.loads(pickle.dumps(one))
    assert "_hash" not in vars(sent) and sent == one
