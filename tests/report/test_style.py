"""One look: colours that can be read and told apart, and files that are the same bytes each time."""

from __future__ import annotations

import io
import itertools
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from gomboc_cad.errors import OutputError
from gomboc_cad.report.style import DARK, INK, LIGHT, LINES, figure_bytes, new_axes, svg_text, write_figure

SRGB_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
COLOUR_BLINDNESS = {
    "none": np.eye(3),
    # Machado, Oliveira, Fernandes, IEEE Trans. Vis. Comput. Graph. 15 (2009) 1291, severity 1.
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}


def linear(color: str) -> np.ndarray:
    """Light of an sRGB colour, by IEC 61966-2-1."""
    values = np.array([int(color[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def contrast(color: str, other: str) -> float:
    """Contrast ratio of WCAG 2.2."""
    dark, light = sorted(float(SRGB_TO_XYZ[1] @ linear(c)) for c in (color, other))
    return (light + 0.05) / (dark + 0.05)


def lab(light: np.ndarray) -> np.ndarray:
    """CIELAB with the white of D65."""
    share = SRGB_TO_XYZ @ np.clip(light, 0.0, 1.0) / (0.95047, 1.0, 1.08883)
    root = np.where(share > 0.008856, np.cbrt(share), 7.787 * share + 16.0 / 116.0)
    return np.array([116.0 * root[1] - 16.0, 500.0 * (root[0] - root[1]), 200.0 * (root[1] - root[2])])


def test_contrast_is_that_of_the_guidelines() -> None:
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#767676", "#ffffff") == pytest.approx(4.54, abs=0.005)  # the well-known lightest grey


def test_the_ink_is_as_good_as_can_be_on_both_grounds() -> None:
    best = contrast(LIGHT, DARK) ** 0.5
    assert best < 4.5
    assert min(contrast(INK, LIGHT), contrast(INK, DARK)) > 0.98 * best


@pytest.mark.parametrize("color", LINES)
@pytest.mark.parametrize("ground", [LIGHT, DARK])
def test_lines_stand_out_from_both_grounds(color: str, ground: str) -> None:
    assert contrast(color, ground) >= 3.0


@pytest.mark.parametrize("kind", COLOUR_BLINDNESS)
def test_lines_can_be_told_apart(kind: str) -> None:
    seen = [lab(COLOUR_BLINDNESS[kind] @ linear(color)) for color in (*LINES, INK)]
    nearest = min(np.linalg.norm(a - b) for a, b in itertools.combinations(seen, 2))
    # A difference of 2.3 is just noticeable.
    assert nearest > 4.0 * 2.3


@pytest.fixture
def figure() -> Figure:
    ax = new_axes(None, (4.0, 3.0))
    ax.plot([0.0, 1.0], [0.0, 1.0], color=LINES[0], label="a line")
    ax.fill_between([0.0, 1.0], [0.2, 0.3], rasterized=True)
    ax.set(xlabel="length / mm")
    ax.legend()
    found = ax.get_figure(root=True)
    assert found is not None
    return found


@pytest.mark.parametrize("kind", ["svg", "png"])
def test_the_bytes_are_the_same_each_time(figure: Figure, kind: str) -> None:
    first = figure_bytes(figure, kind)
    assert figure_bytes(figure, kind) == first


def test_an_svg_file_keeps_its_text_and_tells_nothing_of_its_making(figure: Figure) -> None:
    text = figure_bytes(figure, "svg").decode()
    assert "length / mm" in "".join(ElementTree.fromstring(text).itertext())
    assert INK not in text
    addresses = set(re.findall(r'https?://[^"\s<]+', text))
    assert addresses == {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}  # namespaces
    assert "metadata" not in text


def test_figures_of_one_page_do_not_mix_their_parts(figure: Figure) -> None:
    known: set[str] = set()
    for name in ("one", "two"):
        text = svg_text(figure, name)
        assert text.startswith("<svg")
        own = set(re.findall(r'\bid="([^"]+)"', text))
        used = set(re.findall(r'(?:url\(#|href="#)([^")]+)', text))
        assert used <= own
        assert not known & own
        known |= own
        assert "<text" not in text
        assert "currentColor" in text


def test_the_ground_of_a_picture_is_transparent(figure: Figure) -> None:
    with Image.open(io.BytesIO(figure_bytes(figure, "png"))) as image:
        assert image.size == (600, 450)
        assert image.getpixel((1, 1))[3] == 0


def test_the_style_of_the_caller_is_left_alone(figure: Figure) -> None:
    import matplotlib as mpl

    # The backend is found out when it is asked for.
    before = {name: value for name, value in mpl.rcParams.items() if name != "backend"}
    figure_bytes(figure, "svg")
    new_axes(None, (1.0, 1.0))
    assert {name: mpl.rcParams[name] for name in before} == before


def test_axes_of_the_wrong_kind_are_refused(figure: Figure) -> None:
    with pytest.raises(ValueError, match="mollweide"):
        new_axes(figure.axes[0], (1.0, 1.0), "mollweide")


def test_other_files_are_refused(figure: Figure, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"\.png or \.svg"):
        write_figure(figure, tmp_path / "figure.pdf")
    assert list(tmp_path.iterdir()) == []
