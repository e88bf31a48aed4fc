"""The declarations of a check module are checked when its tests are made."""

import types

import pytest

from checks import make_tests

pytestmark = pytest.mark.quick


def module_with(**names):
    module = types.ModuleType("check_sample")
    vars(module).update(names)
    return module


def test_checks_become_tests():
    calls = []

    def check_line(dx, data):
        calls.append((dx, data))
        assert -5 <= dx <= 5 and len(data) <= 2

    tests = make_tests(
        module_with(
            check_line=check_line,
            check_golden=lambda: None,
            CASES={"check_line": (("dx", -5, 5), ("data", "bytes", 2))},
            RUNS={"check_line": 7},
        )
    )
    assert sorted(tests) == ["check_golden", "check_line"]
    tests["check_line"]()
    assert 1 <= len(calls) <= 7


@pytest.mark.parametrize(
    "cases",
    [{}, {"check_line": (("dy", 0, 1),)}, {"check_line": (("dx", 0, 1),), "check_lines": ()}],
    ids=["none given", "another parameter", "another check"],
)
def test_a_wrong_declaration_is_refused(cases):
    def check_line(dx):
        pass

    with pytest.raises(ValueError):
        make_tests(module_with(check_line=check_line, CASES=cases))
