"""Measured maps: what is read, how it is treated, and what is refused."""

import io
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from comparisons.formatting import with_unit
from comparisons.geometry.faces import read_map
from comparisons.geometry.map_files import libraries
from comparisons.geometry.reading import FileError
from comparisons.scene.surface import MeasuredMap

DATA = Path(__file__).parents[3].parent / "shared" / "data"
SIZE = (3e-6, 2e-6)


def measured(name: str) -> Path:
    """Return a real measurement, which lies beside the repository and is never copied."""
    pytest.importorskip("SurfaceTopography")
    if not (DATA / name).is_file():
        pytest.skip(f"no {DATA / name}")
    return DATA / name


@pytest.fixture
def rough():
    """Heights in nm with no symmetry at all: any mistaken axis or sign shows."""
    return np.random.default_rng(7).normal(size=(12, 9)) + np.linspace(0, 3, 12)[:, None]


@pytest.fixture
def store(tmp_path):
    def save(array, name="map.npy"):
        np.save(tmp_path / name, array)
        return tmp_path / name

    return save


def spacing(surface):
    return tuple(side / n for side, n in zip(surface.size, surface.heights.shape, strict=True))


def read(path, **options):
    return read_map(path, MeasuredMap(kind="map", file=path.name, **options))


def plain(path, **options):
    return read(path, **({"size": SIZE, "height_unit": "nm"} | options))


def problems_of(path, **options):
    with pytest.raises(FileError) as caught:
        plain(path, **options)
    return caught.value.problems


def test_first_index_is_x_and_up_is_towards_the_half_space(store, rough):
    surface = plain(store(rough), detrend="none")
    assert surface.heights.shape == (12, 9)
    assert np.array_equal(surface.heights, rough / 1e9)
    assert surface.size == SIZE
    assert spacing(surface) == pytest.approx((0.25e-6, 2e-6 / 9), rel=1e-15)
    assert surface.heights.flags.c_contiguous
    assert not surface.heights.flags.writeable
    assert not any("undefined" in step for step in surface.treatment)
    columns = plain(store(np.asfortranarray(rough)), detrend="none", size=5e-6)
    assert np.array_equal(columns.heights, rough / 1e9)
    assert columns.heights.flags.c_contiguous
    assert columns.size == (5e-6, 5e-6)  # one side length means a square


@pytest.mark.parametrize(
    ("name", "delimiter"), [("m.csv", ","), ("m.csv", ";"), ("m.txt", "\t"), ("m.TXT", " ")]
)
@pytest.mark.parametrize("mark", ["", "\N{ZERO WIDTH NO-BREAK SPACE}"])  # as of spreadsheets
def test_text_tables_hold_the_same_heights(tmp_path, rough, name, delimiter, mark):
    path = tmp_path / name
    np.savetxt(path, rough, delimiter=delimiter, header="made by hand", fmt="%.17g")
    path.write_text(mark + path.read_text(), encoding="utf-8")
    assert np.array_equal(plain(path, detrend="none").heights, rough / 1e9)


@pytest.mark.parametrize("dtype", ["int16", "uint8", "float32", ">f8", "float16"])
def test_any_real_type_becomes_float64(store, dtype):
    numbers = np.array([[1, 2, 3], [4, 5, 7]], dtype)
    surface = plain(store(numbers), detrend="none")
    assert surface.heights.dtype == np.float64
    assert np.array_equal(surface.heights, numbers.astype(float) / 1e9)


@pytest.mark.parametrize(
    ("unit", "metres"), [("m", 1), ("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6), ("pm", 1e-12)]
)
def test_units(store, rough, unit, metres):
    surface = plain(store(rough), height_unit=unit, detrend="none")
    assert np.allclose(surface.heights, rough * metres, rtol=1e-15)


def test_crop_keeps_the_spacing_and_is_counted_in_points_of_the_file(store, rough):
    whole = plain(store(rough), detrend="none")
    part = plain(store(rough), detrend="none", crop=(2, 3, 6, 4))
    assert np.array_equal(part.heights, whole.heights[2:8, 3:7])
    assert spacing(part) == pytest.approx(spacing(whole), rel=1e-15)
    assert any("cropped to 6 x 4 points from (2, 3)" in item for item in part.treatment)


def test_inversion_turns_valleys_into_peaks(store, rough):
    upright, inverted = (plain(store(rough), invert=flag) for flag in (False, True))
    assert np.array_equal(inverted.heights, -upright.heights)
    assert any("inverted" in part for part in inverted.treatment)


TERMS = {
    "mean": ((0, 0),),
    "tilt": ((0, 0), (1, 0), (0, 1)),
    "curvature": ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)),
}


@pytest.mark.slow
@pytest.mark.parametrize("detrend", TERMS)
@given(seed=st.integers(0, 2**32 - 1), steepness=st.floats(-1e4, 1e4))
def test_trend_leaves_no_trace(tmp_path_factory, detrend, seed, steepness):
    """Whatever trend is added beforehand, the same heights come out, orthogonal to every term.

    To 1e-14 of the trend's own size: its subtraction cannot do better than the file's rounding.
    """
    rng = np.random.default_rng(seed)
    heights = rng.normal(size=(11, 14))
    x, y = np.meshgrid(np.arange(11) / 11, np.arange(14) / 14, indexing="ij")
    trend = sum(rng.normal() * x**a * y**b for a, b in TERMS[detrend]) * steepness
    path = tmp_path_factory.mktemp("trend") / "map.npy"
    np.save(path, heights)
    bare = plain(path, detrend=detrend, height_unit="m").heights
    np.save(path, heights + trend)
    steep = plain(path, detrend=detrend, height_unit="m").heights
    size = 1 + np.abs(trend).max()
    assert np.abs(steep - bare).max() < 1e-14 * size
    for a, b in TERMS[detrend]:
        assert abs((bare * x**a * y**b).mean()) < 1e-14


def test_trend_is_fitted_to_defined_points_only(store):
    """A plane with a hole and one spike beside it: the hole's content must not tilt the fit."""
    x, y = np.meshgrid(np.arange(10.0), np.arange(8.0), indexing="ij")
    heights = 3 * x - 2 * y
    rough = np.where((x + y) % 2 == 0, 1.0, -1.0)
    holes = (x > 6) & (y > 5)
    level = plain(store(np.where(holes, np.nan, rough)), undefined="lowest")
    tilted = plain(store(np.where(holes, np.nan, rough + heights)), undefined="lowest")
    # 30 is the size of the plane in nm.
    assert np.allclose(tilted.heights, level.heights, rtol=0, atol=30e-9 * 1e-14)


def test_order_of_the_treatment(store, rough):
    surface = plain(
        store(np.where(rough > 3, np.nan, rough)),
        crop=(1, 1, 10, 7),
        invert=True,
        undefined="lowest",
    )
    steps = [part.split()[0] for part in surface.treatment]
    assert steps == ["heights", "cropped", "inverted:", "least-squares", steps[-1]]
    assert "set to the lowest" in surface.treatment[-1]


def test_lowest_is_what_touches_last_also_when_inverted(store, rough):
    rough[4, 5] = np.nan
    for invert in (False, True):
        surface = plain(store(rough), undefined="lowest", invert=invert)
        assert surface.heights[4, 5] == surface.heights.min()


@given(seed=st.integers(0, 2**32 - 1), share=st.floats(0.02, 0.9))
def test_interpolation_invents_no_peak(tmp_path_factory, seed, share):
    """Each filled point is the weighted mean of its neighbours, hence never above them."""
    rng = np.random.default_rng(seed)
    heights = rng.normal(size=(9, 13))
    holes = rng.random(heights.shape) < share
    holes[0, 0], holes[2, 2], holes[8, 12] = True, False, False
    heights[2, 2], heights[8, 12] = -5.0, 5.0
    path = tmp_path_factory.mktemp("holes") / "map.npy"
    np.save(path, np.where(holes, np.nan, heights))
    surface = plain(path, detrend="none", height_unit="m", undefined="interpolate")
    assert any(f"{holes.sum()} of {holes.size} points" in step for step in surface.treatment)
    filled = surface.heights
    assert np.array_equal(filled[~holes], heights[~holes])
    weight_x, weight_y = (1 / step**2 for step in spacing(surface))
    padded = np.pad(filled, 1, constant_values=np.nan)
    for i, j in np.argwhere(holes):
        around = padded[[i, i + 2, i + 1, i + 1], [j + 1, j + 1, j, j + 2]]
        weights = np.array([weight_x, weight_x, weight_y, weight_y])[~np.isnan(around)]
        mean = np.average(around[~np.isnan(around)], weights=weights)
        assert filled[i, j] == pytest.approx(mean, rel=0, abs=1e-11)


def test_a_periodic_map_has_no_trend_but_its_mean(store, rough):
    """The plane that fits a window is not that of the rolled window: the surface has none."""
    surface = plain(store(rough), periodic=True)
    assert "mean subtracted" in surface.treatment
    np.testing.assert_allclose(surface.heights * 1e9, rough - rough.mean(), atol=1e-14)
    level = plain(store(rough), periodic=True, detrend="none")
    assert np.array_equal(level.heights, rough / 1e9)
    for trend in ("tilt", "curvature"):
        with pytest.raises(ValidationError, match=f"expected 'mean'.*got {trend!r}"):
            plain(store(rough), periodic=True, detrend=trend)


def test_holes_of_a_periodic_map_are_filled_from_across_its_sides(store, rough):
    """Where the period is cut changes no height. 1e-13 nm: the solution in another order."""
    holes = np.zeros(rough.shape, bool)
    holes[0, 2:5] = holes[-2:, 3] = holes[4, 0] = holes[4, -2:] = holes[0, 0] = True
    rough[holes] = np.nan
    options = {"periodic": True, "detrend": "none", "undefined": "interpolate"}
    filled = plain(store(rough), **options).heights
    rolled = plain(store(np.roll(rough, (5, 3), (0, 1))), **options).heights
    np.testing.assert_allclose(np.roll(filled, (5, 3), (0, 1)), rolled, atol=1e-22)
    free = plain(store(rough), **(options | {"periodic": False})).heights
    assert np.abs(filled - free)[holes].max() > 1e-11


def test_sides_that_do_not_join_are_named(store):
    """A wave joins itself wherever it is cut, and so does a groove; on a slope it does not."""
    x = np.arange(16)[:, None] * np.ones(9)
    wave, groove = np.cos(2 * np.pi * x / 16), np.where(x < 5, -1.0, 0.0)
    for heights in (wave, np.roll(wave, 3, axis=0), groove):
        notes = plain(store(heights), periodic=True).treatment
        assert not any("declared periodic" in item for item in notes)
    *_, note = plain(store(wave + x), periodic=True).treatment
    assert note.startswith("declared periodic, but along x the last line and the first differ by")
    *_, note = plain(store(wave + x)).treatment
    assert "periodic" not in note


def test_all_problems_of_the_options_come_at_once(tmp_path):
    problems = problems_of(tmp_path / "absent.csv", height_unit="furlong", channel="Height")
    words = ("no such file", "furlong", "Height")
    assert len(problems) == len(words)
    for word, problem in zip(words, problems, strict=True):
        assert word in problem


def test_a_folder_is_no_map_and_a_crop_ends_where_the_map_does(tmp_path, store, rough):
    assert problems_of(tmp_path, size=None, height_unit=None) == ("is a folder",)
    (problem,) = problems_of(store(rough), crop=(4, 0, 9, 9))
    assert "[4, 0, 9, 9]" in problem
    assert "12 x 9" in problem


def test_plain_tables_need_size_and_unit(store, rough):
    with pytest.raises(FileError, match=r"size is needed.*height_unit is needed"):
        read(store(rough))


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.ones(5), "two dimensions"),
        (np.ones((3, 4, 2)), "two dimensions"),
        (np.ones((1, 7)), "at least 2 x 2"),
        (np.ones((0, 7)), "at least 2 x 2"),
        (np.ones((3, 3), complex), "complex128"),
        (np.ones((3, 3), bool), "bool"),
        (np.array([["a", "b"], ["c", "d"]]), "<U1"),
        (np.full((4, 4), 3.7), "flat"),
        (np.arange(6.0)[:, None] * np.ones(5), "flat"),  # nothing is left of a plane
    ],
)
def test_arrays_that_are_no_map(store, array, message):
    (problem,) = problems_of(store(array))
    assert message in problem


def stored(array) -> bytes:
    np.save(stream := io.BytesIO(), array, allow_pickle=True)
    return stream.getvalue()


HUGE = {"descr": "<f8", "fortran_order": False, "shape": (10**8, 10**8)}
np.lib.format.write_array_header_1_0(promised := io.BytesIO(), HUGE)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("m.npy", b"", "empty"),
        ("m.npy", stored(np.array([[1, None], [2, 3]], object)), "object"),  # never unpickled
        ("m.npy", stored(np.ones((12, 9)))[:-8], "not a readable .npy"),
        ("m.npy", promised.getvalue(), "not a readable .npy file"),  # of 80 GB
        ("m.npy", b"no header at all", "not a readable .npy"),
        ("m.npy", b"\x93NUMPY\x01\x00\x08\x00{'a': (\n", "not a readable .npy"),
        ("m.csv", b"\n# nothing\n", "no numbers"),
        ("m.csv", b"x,y\n1,2\n", "not a plain table"),
        ("m.csv", b"1,2\n3\n", "not a plain table"),
        ("m.txt", b"\xff\xfe\x00", "not a plain table"),
        ("m.csv", b"1,2,3\n", "at least 2 x 2"),
    ],
)
def test_damaged_files(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_bytes(content)
    (problem,) = problems_of(path)
    assert message in problem


def test_nan_in_a_plain_table_is_a_mistake_unless_said_otherwise(store, rough):
    rough[3, 4] = rough[7, 1] = np.nan
    (problem,) = problems_of(store(rough))
    assert problem.startswith("2 NaN in the map, the first at index (3, 4)")
    (problem,) = problems_of(store(rough), crop=(5, 0, 5, 5))
    assert problem.startswith("1 NaN in the map, the first at index (7, 1)")
    assert "2 of 108" in problems_of(store(rough), undefined="refuse")[0]
    assert np.isfinite(plain(store(rough), undefined="interpolate").heights).all()


def test_infinite_heights_are_always_a_mistake(store, rough):
    rough[2, 2], rough[3, 3] = np.inf, -np.inf
    for undefined in (None, "interpolate", "lowest"):
        (problem,) = problems_of(store(rough), undefined=undefined)
        assert problem == "2 infinite heights, the first at index (2, 2)"
    rough[:] = np.nan
    assert problems_of(store(rough), undefined="lowest") == ("no point of the map is defined",)


@pytest.mark.parametrize("name", ["m.npy", "m.csv"])
def test_maps_beyond_the_memory_are_refused_before_they_are_read(
    tmp_path, monkeypatch, rough, name
):
    """With 1 kB free, 108 points do not fit, and of an .npy a crop of 2 x 2 does."""
    path = tmp_path / name
    (np.save if name == "m.npy" else np.savetxt)(
        path, rough, **({"delimiter": ","} if "csv" in name else {})
    )
    monkeypatch.setattr(psutil, "virtual_memory", lambda: SimpleNamespace(available=1000))
    monkeypatch.setattr(np, "loadtxt", lambda *_, **__: pytest.fail("read all the same"))
    assert "GB of memory" in problems_of(path)[0]
    if name == "m.npy":
        assert plain(path, crop=(0, 0, 2, 2), detrend="none").heights.shape == (2, 2)


@pytest.mark.parametrize(
    ("package", "opened", "extra"),
    [
        ("SurfaceTopography", libraries.open_instrument, "topography"),
        ("tifffile", libraries.open_tiff, "topography"),
        ("h5py", libraries.open_hdf5, "challenge"),
    ],
)
def test_without_an_optional_package_the_message_names_it(
    tmp_path, monkeypatch, package, opened, extra
):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(FileError, match=rf"pip install roughline\[{extra}\]"):
        opened(tmp_path / "scan", MeasuredMap(kind="map", file="scan"))


@pytest.mark.slow
def test_unknown_formats_say_what_was_tried(tmp_path):
    pytest.importorskip("SurfaceTopography")
    path = tmp_path / "scan.di"
    path.write_bytes(b"no scan at all")
    with pytest.raises(FileError, match=r"unknown or damaged.*formats of SurfaceTopography.* opd,"):
        read(path)


def test_truncated_instrument_file(tmp_path, capfd):
    """The reader that the suffix promises is quoted, on one line, and prints nothing."""
    path = tmp_path / "scan.opd"
    path.write_bytes(measured("opd-1.opd").read_bytes()[:100_000])
    with pytest.raises(FileError, match="as opd: ") as caught:
        read(path)
    assert len(str(caught.value)) < 1000
    assert capfd.readouterr() == ("", "")


def test_atomic_force_microscope_map_is_the_scan_it_was():
    """Against the file's own numbers: 16 bit, line by line, after 40960 bytes of text.

    The lines run along x, the first one is the top of the picture and y points up.
    """
    path = measured("di-2.di")
    surface = read(path, detrend="none")
    assert surface.heights.shape == (512, 512)
    assert surface.size == pytest.approx((300e-9, 300e-9), rel=1e-12)
    raw = np.frombuffer(path.read_bytes(), "<i2", 512 * 512, offset=40960).reshape(512, 512)
    slope, offset = np.polyfit(raw.ravel(), np.rot90(surface.heights).ravel(), 1)
    assert slope > 0  # peaks stay peaks
    misfit = np.abs(np.rot90(surface.heights) - slope * raw - offset).max()
    turned = [np.abs(np.rot90(surface.heights, k) - slope * raw - offset).max() for k in (0, 2, 3)]
    assert misfit < 1e-12 * np.ptp(surface.heights) < min(turned)
    assert "'Deflection'" in surface.treatment[0]


def test_interferometer_map_with_undefined_points():
    path = measured("opd-1.opd")
    surface = read(path)
    assert surface.heights.shape == (640, 480)
    assert spacing(surface)[0] == pytest.approx(spacing(surface)[1], rel=1e-6)
    assert surface.treatment[-1] == (
        "116 of 307200 points (0.04 %) undefined: interpolated from their neighbours"
    )
    assert np.isfinite(surface.heights).all()
    assert abs(surface.heights.mean()) < 1e-3 * surface.heights.std()
    # No invented peak: the highest point is one that was measured.
    lowest = read(path, undefined="lowest")
    assert surface.heights.max() == lowest.heights.max()
    with pytest.raises(FileError, match=r"116 of 307200 points \(0\.04 %\) are undefined"):
        read(path, undefined="refuse")


def test_a_crop_full_of_undefined_points_is_refused_by_default():
    path = measured("opd-1.opd")
    with pytest.raises(FileError, match=r"37 of 80 points \(46\.25 %, 5 % or more\)"):
        read(path, crop=(80, 435, 8, 10))
    surface = read(path, crop=(80, 435, 8, 10), undefined="interpolate")
    assert any("37 of 80 points" in step for step in surface.treatment)


def test_channels():
    path = measured("di-6.di")
    first = read(path)
    assert np.array_equal(first.heights, read(path, channel="Height").heights)
    second = read(path, channel="1")
    assert not np.array_equal(first.heights, second.heights)
    for signal in ("Phase", "AmplitudeError", "2"):
        with pytest.raises(FileError, match="does not hold heights"):
            read(path, channel=signal)
    with pytest.raises(FileError, match=r"no channel 'Current'.*0 'Height', 1 'Height', 2 'Phase'"):
        read(path, channel="Current")
    with pytest.raises(FileError, match="'Deflection'"):  # nm in the file, and no height
        read(measured("di-2.di"), channel="Deflection")


def test_what_the_file_states_is_not_stated_again():
    path = measured("di-2.di")
    with pytest.raises(FileError, match=r"own unit \(nm\).*own size \(300 x 300 nm\)"):
        read(path, size=1e-6, height_unit="um")


def test_what_the_file_leaves_open_is_asked_for(tmp_path, rough):
    """An ASCII export without a header: its lines are rows along x, as SurfaceTopography reads."""
    pytest.importorskip("SurfaceTopography")
    path = tmp_path / "scan.asc"
    np.savetxt(path, rough)
    with pytest.raises(FileError, match=r"no unit: give height_unit; .* no size: give size"):
        read(path)
    surface = read(path, size=SIZE, height_unit="nm", detrend="none")
    assert np.allclose(surface.heights, rough.T * 1e-9, rtol=1e-12)
    assert surface.size == SIZE


@pytest.mark.parametrize("periodic", [True, False])
def test_the_cut_off_halves_a_wave_of_its_length_and_keeps_the_mean(store, periodic):
    """ISO 16610-61: 1/2 at the cut-off, 2^-(cut-off/length)^2 in general, on cells of any shape."""
    i, j = np.meshgrid(np.arange(64) + 0.5, np.arange(48) + 0.5, indexing="ij")
    # Whole waves of a period, half-waves of a patch (with its mirror image): what filters keep.
    kx, ky = (8, 3) if periodic else (11, 6)
    turn = 2 if periodic else 1
    path = store(5 + np.cos(turn * np.pi * kx * i / 64) * np.cos(turn * np.pi * ky * j / 48))
    stated = {"size": ("2 um", "1 um"), "detrend": "none", "periodic": periodic}
    length = 1 / np.hypot(turn * kx / 2 / 2e-6, turn * ky / 2 / 1e-6)
    raw = plain(path, **stated).heights
    for cutoff in (length, 0.7 * length):
        filtered = plain(path, **stated, short_cutoff=cutoff).heights
        expected = raw.mean() + 0.5 ** (cutoff / length) ** 2 * (raw - raw.mean())
        np.testing.assert_allclose(filtered, expected, atol=1e-12 * raw.max())


def test_the_cut_off_halves_the_shortest_wave_of_a_map_too(store):
    path = store(np.outer((-1.0) ** np.arange(32), np.ones(24)))
    raw, filtered = (
        plain(path, size=("3.2 um", "2.4 um"), periodic=True, **more).heights
        for more in ({}, {"short_cutoff": "0.2 um"})
    )
    np.testing.assert_allclose(filtered, raw / 2, atol=1e-12 * raw.max())


def test_a_cut_off_below_two_cells_or_above_the_side_is_refused(store, rough):
    path = store(rough)
    ends = f"2 cells = {with_unit(5e-7, 'm')} to the side {with_unit(2e-6, 'm')}"
    for cutoff in ("0.4 um", "2.1 um"):  # cells of 0.25 and 0.22 um, sides of 3 and 2 um
        (told,) = problems_of(path, short_cutoff=cutoff)
        assert told.startswith(f"short_cutoff: expected {ends}")
