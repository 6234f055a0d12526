"""Names of files that stand for labels."""

from __future__ import annotations

import string
from urllib.parse import unquote

from hypothesis import given
from hypothesis import strategies as st

from oitbench.filenames import file_name

LABELS = st.text(st.characters(exclude_categories=()), max_size=300)


@given(LABELS)
def test_names_are_plain_and_short(label: str) -> None:
    name = file_name(label)
    assert 0 < len(name) < 130
    assert set(name) <= {*string.ascii_letters, *string.digits, *"_-.=,+@%~"}
    assert not name.startswith(".")


@given(LABELS.filter(lambda label: "~" not in file_name(label)))
def test_the_label_of_a_short_name_can_be_read_back(label: str) -> None:
    assert unquote(file_name(label), errors="surrogatepass") == label


def test_labels_that_look_alike_have_different_names() -> None:
    long = "x" * 250
    labels = [
        "my-method", "my_method", "my method", "a[x=1e-15]", "a[x=1e+15]", "a_x=1_", "../a", "a",
        "", ".", "..", "%2E", "~", "a/b", long, f"{long}y", file_name(long), file_name(""),
    ]  # fmt: skip
    assert len({file_name(label) for label in labels}) == len(labels)
    assert not any(file_name(label).startswith(".") for label in labels)
    assert file_name("glass_bars") == "glass_bars"
