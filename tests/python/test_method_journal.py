"""Tests for the journal of an experiment."""

import math

import pytest

from ragdoll.errors import InputError
from ragdoll.method.journal import Journal, is_journal


def test_what_was_added_is_there_again_bit_for_bit(tmp_path):
    path = tmp_path / "journal.jsonl"
    result = {"residual": [0.1 + 0.2, 1e-300, math.inf], "iterations": [2**53 + 1]}
    with Journal(path, "f", {}) as journal:
        journal.add("a", result)
    with Journal(path, "f", {}) as journal:
        assert journal.finished == {"a": result}
    assert is_journal(path)


@pytest.mark.parametrize("lost", [1, 5, 30])
def test_a_torn_line_is_dropped_and_what_follows_is_whole(tmp_path, lost):
    path = tmp_path / "journal.jsonl"
    with Journal(path, "f", {}) as journal:
        journal.add("a", {"n": [1]})
        journal.add("b", {"n": [2]})
    path.write_bytes(path.read_bytes()[:-lost])
    with Journal(path, "f", {}) as journal:
        assert list(journal.finished) == ["a"]
        journal.add("c", {"n": [3]})
    with Journal(path, "f", {}) as journal:
        assert list(journal.finished) == ["a", "c"]


def test_the_first_line_may_be_torn(tmp_path):
    path = tmp_path / "journal.jsonl"
    path.write_bytes(b'{"ragdoll_exp')
    assert is_journal(path)
    with Journal(path, "f", {}) as journal:
        assert journal.finished == {}


def test_another_experiment_is_refused_unless_it_is_to_be_replaced(tmp_path):
    path = tmp_path / "journal.jsonl"
    with Journal(path, "f", {}) as journal:
        journal.add("a", {})
    with pytest.raises(InputError, match="another experiment"):
        Journal(path, "g", {})
    with Journal(path, "g", {}, replace=True) as journal:
        assert journal.finished == {}


def test_two_cannot_write_at_once(tmp_path):
    path = tmp_path / "journal.jsonl"
    with Journal(path, "f", {}), pytest.raises(InputError, match="wait for it"):
        Journal(path, "f", {})


def test_a_file_of_something_else_is_no_journal(tmp_path):
    path = tmp_path / "journal.jsonl"
    path.write_text("a diary of mine\n")
    assert not is_journal(path)
