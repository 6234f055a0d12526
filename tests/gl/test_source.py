"""Shaders are assembled from files, and errors name the file and line of their origin."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.errors import DeclarationError
from oitbench.gl.device import Device
from oitbench.gl.program.source import Source
from tests.helpers import Layer, foreign_method, render, stack, write_method

SIMPLE = '(Gather("draw.glsl", writes={"color": ADD}),)'


def source_of(folder: Path, **files: str) -> Source:
    for name, text in files.items():
        (folder / f"{name}.glsl").write_text(text)
    return Source([folder])


def failure(device: Device, folder: Path, **shaders: str) -> str:
    """Render a method with these shaders, and return the message of the error."""
    chosen = foreign_method(write_method(folder / "simple", SIMPLE, **shaders))
    with pytest.raises(DeclarationError) as caught:
        render(device, stack([Layer(2, 0.5)]), chosen)
    return str(caught.value).replace(str(folder), "")


def test_files_are_assembled_in_order(tmp_path: Path) -> None:
    source = source_of(tmp_path, first="float a;\n", second="float b;\n")
    source.add_text("prelude", "#define A 1")
    source.add_file("first.glsl")
    source.add_file("second.glsl")
    assert source.text.splitlines() == [
        "#version 450 core",
        "#define A 1",
        "float a;",
        "float b;",
    ]


def test_an_include_is_replaced_by_its_file(tmp_path: Path) -> None:
    source = source_of(tmp_path, main='float a;\n#include "part.glsl"\nfloat b;\n', part="float p;")
    source.add_file("main.glsl")
    main, part = str(tmp_path / "main.glsl"), str(tmp_path / "part.glsl")
    assert source.lines == ["float a;", "float p;", "float b;"]
    assert source.places == [(main, 1), (part, 1), (main, 3)]


def test_a_file_is_included_once_and_never_in_itself(tmp_path: Path) -> None:
    source = source_of(
        tmp_path,
        main='#include "a.glsl"\n#include "b.glsl"\n#include "b.glsl"\n',
        a='#include "b.glsl"\n',
        b="float b;\n",
        loop='float x;\n#include "back.glsl"\n',
        back='#include "loop.glsl"\n',
    )
    source.add_file("main.glsl")
    assert source.text.count("float b;") == 1
    with pytest.raises(DeclarationError, match=r"back\.glsl:1: 'loop\.glsl' includes itself"):
        source.add_file("loop.glsl")


def test_engine_shaders_are_not_replaced_by_files_of_a_method(tmp_path: Path) -> None:
    source = source_of(tmp_path, random="// mine\n", own='#include "oitbench/random.glsl"\n')
    source.add_engine_file("shadow_map.glsl")
    source.add_file("own.glsl")
    assert "// mine" not in source.text
    assert source.text.count("uvec3 hash(uvec3 v)") == 1
    source.add_file("random.glsl")
    assert "// mine" in source.text


def test_the_folder_of_a_method_precedes_that_of_its_collection(tmp_path: Path) -> None:
    own, shared = tmp_path / "own", tmp_path / "glsl"
    for folder, names in ((own, ("a",)), (shared, ("a", "b"))):
        folder.mkdir()
        for name in names:
            (folder / f"{name}.glsl").write_text(f"// {name} of {folder.name}\n")
    source = Source([own, shared])
    source.add_file("a.glsl")
    source.add_file("b.glsl")
    assert source.lines == ["// a of own", "// b of glsl"]


def test_shaders_of_a_kit_include_files_of_the_method(tmp_path: Path) -> None:
    source = source_of(tmp_path, curve="// mine\n")
    source.add_file("absorbance/build.glsl")
    assert "// mine" in source.text
    assert any(place.startswith("oitbench/method/kits/absorbance/") for place, _ in source.places)


def test_the_error_for_a_missing_file_names_its_folder(tmp_path: Path) -> None:
    with pytest.raises(DeclarationError, match=r"there is no shader 'nothing\.glsl'") as caught:
        Source([tmp_path]).add_file("nothing.glsl")
    assert str(tmp_path) in str(caught.value)


@pytest.mark.parametrize(
    "log",
    [
        "0:4(12): error: `x' undeclared",
        "0(4) : error C1503: undefined variable",
        "ERROR: 0:4: 'x' : undeclared",
    ],
)
def test_the_line_formats_of_all_drivers_are_understood(tmp_path: Path, log: str) -> None:
    source = source_of(tmp_path, main="float a;\nfloat b;\n")
    source.add_text("prelude", "#define A 1")
    source.add_file("main.glsl")
    message = source.explain(f"GLSL Compiler failed\n\nfragment_shader\n===\n{log}\n")
    assert message.startswith(f"{tmp_path / 'main.glsl'}:2: ")
    assert "\n" not in message


def test_a_compile_error_names_the_file_and_line_of_the_plugin(
    device: Device, tmp_path: Path
) -> None:
    message = failure(
        device, tmp_path, draw="// one\nvoid gather(Fragment fragment) {\n    color = nowhere;\n}\n"
    )
    assert message.startswith("/simple/draw.glsl:3: error")
    assert "nowhere" in message


def test_errors_in_and_after_an_include_have_the_right_place(
    device: Device, tmp_path: Path
) -> None:
    draw = '\n#include "part.glsl"\nvoid gather(Fragment fragment) {\n    color = four();\n}\n'
    message = failure(device, tmp_path / "in", draw=draw, part="\n\nvec4 four() { return 4; }\n")
    assert message.startswith("/simple/part.glsl:3: error")
    message = failure(
        device, tmp_path / "after", draw=draw, part="\nvec3 four() { return vec3(4.0); }\n"
    )
    assert message.startswith("/simple/draw.glsl:4: error")


def test_a_shader_cannot_use_resources_that_its_pass_does_not_declare(
    device: Device, tmp_path: Path
) -> None:
    message = failure(
        device, tmp_path, draw="void gather(Fragment fragment) { color = read_opaque_color(); }"
    )
    assert message.startswith("/simple/draw.glsl:1: error")
    assert "read_opaque_color" in message


def test_a_shader_without_its_function_is_refused(device: Device, tmp_path: Path) -> None:
    message = failure(device, tmp_path, draw="void gathers(Fragment fragment) {}\n")
    assert "gather" in message
    assert "\n" not in message
