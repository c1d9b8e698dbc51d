from contextlib import nullcontext

import pytest

from tests.support.messages import assert_names, raises_naming

MESSAGE = (
    "rotor.rb1.clearance = -1 mm (-0.001 m) is not allowed;\n it must be >= 1e-06 and <= 15.5 kg.m2/s (mine.toml)."
)


@pytest.mark.parametrize(
    "fact",
    ["rotor.rb1.clearance", "-1", "-1 mm", "-0.001 m", "1e-06", "<= 15.5 kg.m2/s", "mine.toml", "allowed; it must"],
)
def test_message_names_whole_words_and_numbers(fact):
    assert_names(MESSAGE, fact)


@pytest.mark.parametrize(
    "fact", ["clearance", "rb1", "1", "1 mm", "-0", "-1 m", "15", "5.5", "06", "15.5 kg", "15.5 kg.m2", "mine", "allow"]
)
def test_part_of_a_word_number_or_unit_is_not_named(fact):
    with pytest.raises(pytest.fail.Exception) as failure:
        assert_names(MESSAGE, "-1 mm", fact)
    assert str(failure.value).startswith(f"the message does not name {fact!r}:\nrotor.rb1.clearance = -1 mm")


def test_order_of_facts_does_not_matter():
    assert_names(MESSAGE, "1e-06", "-1", "rotor.rb1.clearance")


@pytest.mark.parametrize(("text", "is_named"), [("force = 0 N must be > 0 N", True), ("force must be > 0 N", False)])
def test_value_and_equal_limit_are_two_facts(text, is_named):
    with nullcontext() if is_named else pytest.raises(pytest.fail.Exception, match="'0 N'"):
        assert_names(text, "0 N", "> 0 N")


def test_error_of_a_block_names_its_facts():
    with raises_naming(ValueError, "mb1.x", "2 m") as error:
        raise ValueError("mb1.x = 2 m")
    assert_names(error, "mb1.x")
    assert_names(error.value, "2 m")


def test_error_of_a_block_that_lacks_a_fact_fails():
    with pytest.raises(pytest.fail.Exception, match=r"'3 m':\nmb1\.x = 2 m$"), raises_naming(ValueError, "3 m"):
        raise ValueError("mb1.x = 2 m")


def test_block_without_error_fails():
    with pytest.raises(pytest.fail.Exception, match="DID NOT RAISE"), raises_naming(ValueError, "mb1.x"):
        pass


@pytest.mark.parametrize("facts", [(), ("",), ("mb1.x", " ")])
def test_check_without_facts_is_refused(facts):
    with pytest.raises(ValueError, match="facts"):
        assert_names(MESSAGE, *facts)
