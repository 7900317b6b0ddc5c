import pickle

import pytest

from gearplay.cli.interrupts import CommandInterruptedError
from gearplay.vocabulary import errors
from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError


def test_exit_codes_are_those_of_the_contract() -> None:
    kinds = [kind for kind in errors.GearplayError.__subclasses__() if kind.__module__ == errors.__name__]
    codes = {kind.__name__: kind.exit_code for kind in kinds}
    assert codes == {"InputError": 2, "SimulationError": 3, "ResourceError": 5, "MeasurementError": 6}
    assert CommandInterruptedError.exit_code == 130


def test_a_fault_is_written_in_the_grammar() -> None:
    fault = Fault("run.seed", -1, "must be 0 or more", "Choose another")
    assert str(fault) == "run.seed = -1: must be 0 or more. Choose another."
    unknown = Fault("rotors.pinion.modul", NO_VALUE, "unknown field", "Did you mean 'module'?")
    assert str(unknown) == "rotors.pinion.modul: unknown field. Did you mean 'module'?"


@pytest.mark.parametrize(
    "value", ["x" * 10_000, "\x1b[2J", "a\nb", "\u202e", "\ud800", 10**4000, [1] * 99, b"\0"]
)
def test_values_are_short_and_harmless(value: object) -> None:
    shown = errors.show_value(value)
    assert len(shown) <= errors.VALUE_LENGTH + 2
    assert shown.isprintable()


def test_an_integer_too_long_to_print_is_shown_in_words() -> None:
    assert errors.show_value(10**10_000) == "an integer of more than 60 digits"


def test_a_value_that_cannot_be_shown_does_not_break_the_message() -> None:
    class Broken:
        def __repr__(self) -> str:
            raise RuntimeError

    assert errors.show_value(Broken()) == "a value of type Broken"


def test_many_faults_are_counted_not_listed() -> None:
    error = InputError([Fault("a", i, "is wrong") for i in range(1000)])
    assert str(error).endswith("... and 960 more faults.")
    assert len(error.faults) == 1000


def test_errors_survive_pickling() -> None:
    error = pickle.loads(pickle.dumps(InputError(Fault("a", NO_VALUE, "is required"))))
    assert str(error) == "a: is required."
    assert error.faults[0].value is NO_VALUE
