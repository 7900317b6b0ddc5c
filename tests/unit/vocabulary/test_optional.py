import pytest

from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.optional import load_optional


def test_a_missing_library_is_named_with_its_cure() -> None:
    with pytest.raises(InputError) as caught:
        load_optional("no_such_library", "calibration")
    assert str(caught.value) == (
        "no_such_library: is needed for this and not installed. Run: pip install 'gearplay[calibration]'."
    )
