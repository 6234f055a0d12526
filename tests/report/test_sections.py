"""A report that fails, exits, crashes or hangs costs its section, and not the page."""

from __future__ import annotations

import pytest

from oitbench.report.sections import Section, build_sections
from tests.report.made_up import context, finished, store

GOOD = '''"""All of it."""
from oitbench.report.artifacts import Statement
title = "Mine & yours"
order = {order}


def build(context):
    return [Statement((f"<i>{{len(context.results.records)}}</i>",))]
'''
EMPTY = """
from oitbench.report import Note
title = "Empty"


def build(context):
    return [Note("run `more`"), Note("run `more`")]
"""
FAULTS = {
    "raises": ("return 1 / 0", "raises.py:5: ZeroDivisionError: division by zero"),
    "quits": ("raise SystemExit(3)", "quits.py:5: SystemExit: 3"),
    "exits": ("import os; os._exit(0)", "ended with code 0 while building the section"),
    "crashes": ("import ctypes; ctypes.string_at(0)", "(SIGSEGV) while building the section"),
    "hangs": ("while True: pass", "took longer than 10 s while building the section"),
    "grows": (
        "x = []\n    while True: x.append(b'1' * 2**20)",
        "needs more than 0.586 GiB of memory while building the section",
    ),
    "nonsense": ("return [7]", "KeyError: <class 'int'>"),
}
ON_LOADING = {
    "exits_early": ("import os; os._exit(9)", "ended with code 9 while loading the file"),
    "untitled": ("def build(context): return []", "defines no 'title'"),
    "wrong": ("this is no Python", "SyntaxError"),
}


@pytest.fixture(scope="module")
def sections(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Section]:
    """The sections of reports with each fault, and of good ones before, between and after."""
    folder = tmp_path_factory.mktemp("reports")
    texts = {"after": GOOD.format(order=2), "a_first": GOOD.format(order=-1), "empty": EMPTY}
    for name, (text, _) in FAULTS.items():
        texts[name] = f'"""No."""\ntitle = "No"\n\ndef build(context):\n    {text}\n'
        texts[f"{name}_later"] = GOOD.format(order=1)
    texts |= {name: text for name, (text, _) in ON_LOADING.items()}
    for name, text in texts.items():
        (folder / f"{name}.py").write_text(text)
    results = tmp_path_factory.mktemp("results")
    record = finished(results, "panes", "murk", 0.2)
    store(results, record)
    paths = {name: folder / f"{name}.py" for name in texts}
    found = build_sections(context(results, [record], folder), paths, 10.0, 600 * 2**20)
    return {section.name: section for section in found}


@pytest.mark.parametrize("name", [*FAULTS, *ON_LOADING])
def test_a_faulty_report_costs_its_section(sections: dict[str, Section], name: str) -> None:
    section = sections[name]
    assert (FAULTS | ON_LOADING)[name][1] in section.error
    assert f"{name}.py" in section.error
    assert "\n" not in section.error
    assert (section.title, section.body) == (name, "")


def test_sections_beside_faulty_ones_are_built_in_their_order(
    sections: dict[str, Section],
) -> None:
    built = [name for name, section in sections.items() if section.body]
    assert built == ["a_first", *sorted(f"{name}_later" for name in FAULTS), "after"]
    for name in built:
        assert "&lt;i&gt;1&lt;/i&gt;" in sections[name].body
        assert (sections[name].title, sections[name].doc) == ("Mine & yours", "All of it.")


def test_a_section_of_notes_alone_is_no_section(sections: dict[str, Section]) -> None:
    assert (sections["empty"].body, sections["empty"].absent) == ("", "run `more`")
