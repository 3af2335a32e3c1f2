"""Formats of measured maps: read with units of their own, or refused in words."""

import numpy as np
import pytest

from comparisons.geometry.faces import read_map
from comparisons.geometry.map_files.heights import read_heights
from comparisons.geometry.reading import FileError
from comparisons.scene.surface import MeasuredMap

STEPS = 0.5, 0.25  # um along x and y


@pytest.fixture
def rough():
    """Heights in nm with no symmetry at all: any mistaken axis or sign shows."""
    return np.random.default_rng(7).normal(size=(6, 5)).round(3)


def points_of(heights):
    """Return lines of x, y (um) and z (nm), x fastest, as profilers export them."""
    i, j = np.meshgrid(*(np.arange(n) for n in heights.shape), indexing="ij")
    table = np.stack([STEPS[0] * i + 100, STEPS[1] * j - 3, heights], axis=-1)
    return table.transpose(1, 0, 2).reshape(-1, 3)


def listed(path, heights, header="", comma=False, delimiter="\t"):
    np.savetxt(path, points_of(heights), fmt="%.6f", delimiter=delimiter, header=header)
    if comma:
        path.write_text(path.read_text().replace(".", ","))
    return path


def read(path, **options):
    return read_map(path, MeasuredMap(kind="map", file=path.name, **options))


def refusal(path, **options) -> str:
    with pytest.raises(FileError) as caught:
        read(path, **options)
    return "; ".join(caught.value.problems)


UNITS = {"lateral_unit": "um", "height_unit": "nm"}


def test_lengths_along_the_surface_have_a_unit_of_their_own(tmp_path, rough):
    """Micrometres beside nanometres: 6 x 5 points of 0.5 by 0.25 um are 3 by 1.25 um."""
    path = listed(tmp_path / "scan.xyz", rough)
    surface = read(path, detrend="none", **UNITS)
    assert surface.size == pytest.approx((3e-6, 1.25e-6), rel=1e-12)
    assert np.array_equal(surface.heights, rough / 1e9)
    assert surface.treatment[0] == "x, y in um and heights in nm read from scan.xyz"


def test_one_unit_does_not_stand_for_the_other(tmp_path, rough):
    path = listed(tmp_path / "scan.xyz", rough)
    assert refusal(path, height_unit="nm") == (
        'the file states no unit of x and y: give lateral_unit, such as "um"'
    )
    assert "no unit of z: give height_unit" in refusal(path, lateral_unit="um")


def test_units_that_the_file_states_are_taken_and_not_overruled(tmp_path, rough):
    header = "Channel: scan\nLateral units: µm\nValue units: nm"
    path = listed(tmp_path / "scan.xyz", rough, header)
    surface = read(path, detrend="none")
    assert surface.size == pytest.approx((3e-6, 1.25e-6), rel=1e-12)
    assert np.array_equal(surface.heights, rough / 1e9)
    assert "the unit of x and y (µm): leave out lateral_unit" in refusal(path, **UNITS)
    assert "leave out size" in refusal(path, size=1e-6)


def test_points_in_any_order_and_missing_ones(tmp_path, rough):
    table = points_of(rough)
    np.random.default_rng(1).shuffle(table)
    np.savetxt(tmp_path / "scan.xyz", table[1:])
    surface = read(tmp_path / "scan.xyz", detrend="none", **UNITS)
    i, j = np.rint((table[0, :2] - (100, -3)) / STEPS).astype(int)
    kept = np.ones(rough.shape, bool)
    kept[i, j] = False
    assert any(f"1 of {rough.size} points" in step for step in surface.treatment)
    assert np.array_equal(surface.heights[kept], rough[kept] / 1e9)


def test_rounded_coordinates_lie_on_the_grid(tmp_path, rough):
    """Thirds printed with two decimals: steps of 0.33 and 0.34."""
    table = points_of(rough)
    table[:, 0] = ((table[:, 0] - 100) / STEPS[0] / 3).round(2)
    np.savetxt(tmp_path / "scan.xyz", table)
    surface = read(tmp_path / "scan.xyz", **UNITS)
    assert surface.heights.shape == rough.shape
    assert surface.size[0] == pytest.approx(6 * 1.67e-6 / 5, rel=1e-12)


def test_scattered_points_are_no_map(tmp_path):
    table = np.random.default_rng(1).random((40, 3))
    np.savetxt(tmp_path / "scan.xyz", table)
    assert "x is not equally spaced" in refusal(tmp_path / "scan.xyz", **UNITS)
    table[:, :2] = np.arange(40)[:, None]
    np.savetxt(tmp_path / "scan.xyz", table)
    assert "40 points on a grid of 40 x 40" in refusal(tmp_path / "scan.xyz", **UNITS)


def test_a_few_lines_do_not_span_a_grid_of_gigabytes(tmp_path):
    """Whatever the suffix: steps of 1e-9 beside 1 need no grid of 1e9 points."""
    lines = "0 0 1\n1e-9 0 2\n1 0 3\n0 1 4\n1e-9 1 5\n1 1 6\n"
    reason = "2 points have the x and y of another point"
    for name in ("scan.xyz", "scan.asc", "scan"):
        (tmp_path / name).write_text(lines)
        assert reason in refusal(tmp_path / name, **UNITS)


def test_a_table_that_lists_coordinates_is_not_taken_for_heights(tmp_path, rough):
    path = listed(tmp_path / "scan.csv", rough, delimiter=",")
    assert "give the file the suffix .xyz" in refusal(path, size=1e-6, height_unit="nm")


def test_lateral_unit_where_no_lengths_are_in_the_file(tmp_path, rough):
    np.save(tmp_path / "map.npy", rough)
    assert "lateral_unit was given" in refusal(tmp_path / "map.npy", size=1e-6, **UNITS)
    assert "lateral_unit must be m, cm" in refusal(tmp_path / "scan.xyz", lateral_unit="inch")


@pytest.mark.parametrize("delimiter", [";", "\t", " "])
def test_decimal_commas_are_read_and_said(tmp_path, rough, delimiter):
    """In a table, and in a list of points."""
    path = tmp_path / "map.csv"
    np.savetxt(path, rough, fmt="%.3f", delimiter=delimiter)
    path.write_text(path.read_text().replace(".", ","))
    points = listed(tmp_path / "scan.xyz", rough, comma=True, delimiter=delimiter)
    table = read(path, size=(3e-6, 1.25e-6), height_unit="nm", detrend="none")
    for surface in (table, read(points, detrend="none", **UNITS)):
        assert np.array_equal(surface.heights, rough / 1e9)
        assert surface.size == pytest.approx((3e-6, 1.25e-6), rel=1e-12)
    assert "with decimal commas" in table.treatment[0]


def test_commas_are_told_apart_by_the_whole_file(tmp_path):
    """The first line alone does not show how decimals are written; 1,234.5 may be 1234.5."""
    path, stated = tmp_path / "map.csv", {"size": 1e-6, "height_unit": "nm", "detrend": "none"}
    path.write_text("0;0;0;1\n0;1,5;2;0\n3;0;0,25;0\n")
    assert read(path, **stated).heights[1, 1] == 1.5e-9
    path.write_text("1,2,3\n4,5,7\n")
    surface = read(path, **stated)
    assert surface.heights.shape == (2, 3)
    assert "decimal commas" not in surface.treatment[0]
    path.write_text("1,234.5;2.0\n3.0;4.0\n")
    assert "may be a decimal comma" in refusal(path, **stated)


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.int16, np.uint16, np.int32])
def test_tiff_image_is_the_map_it_shows(tmp_path, rough, kind):
    """X to the right, y upwards: the last line of the image is y = 0."""
    tifffile = pytest.importorskip("tifffile")
    image = np.round(100 * rough + 500).astype(kind)
    tifffile.imwrite(tmp_path / "map.tif", image)
    surface = read(tmp_path / "map.tif", size=(5e-6, 6e-6), height_unit="nm", detrend="none")
    assert surface.heights.shape == (5, 6)
    assert np.array_equal(surface.heights, image[::-1].T.astype(float) / 1e9)
    whole = "whole numbers" in surface.treatment[0]
    assert whole == np.issubdtype(kind, np.integer)


def test_tiff_of_several_pages_needs_a_choice(tmp_path, rough):
    tifffile = pytest.importorskip("tifffile")
    pages = np.stack([rough, 2 * rough, 3 * rough]).astype(np.float32)
    path = tmp_path / "map.tif"
    tifffile.imwrite(path, pages, photometric="minisblack")
    stated = {"size": 1e-6, "height_unit": "nm", "detrend": "none"}
    assert "pages 0 to 2: choose one as channel" in refusal(path, **stated)
    assert "has no page '7'" in refusal(path, channel="7", **stated)
    second = read(path, channel="1", **stated)
    assert np.array_equal(second.heights, pages[1].astype(float)[::-1].T / 1e9)


@pytest.mark.parametrize(
    ("image", "options", "told"),
    [
        (np.zeros((6, 5), np.uint8), {}, "pixels of 8 bits"),
        (np.zeros((6, 5, 3), np.uint8), {"photometric": "rgb"}, "a picture in colours"),
        (np.zeros((6, 5), np.float32), None, "size is needed"),
        (np.zeros((6, 5), np.float32), None, "height_unit is needed"),
        (None, {}, "not a readable TIFF"),
    ],
)
def test_tiffs_that_are_no_maps_say_why(tmp_path, image, options, told):
    """Pictures, a damaged file, and one whose size and unit nobody states."""
    tifffile, path = pytest.importorskip("tifffile"), tmp_path / "map.tif"
    if image is None:
        path.write_bytes(b"II*\0" + bytes(50))
    else:
        tifffile.imwrite(path, image, **(options or {}))
    stated = {} if options is None else {"size": 1e-6, "height_unit": "nm"}
    assert told in refusal(path, **stated)


HEIGHTS = np.arange(12.0).reshape(3, 4)
STATED = MeasuredMap(kind="map", file="surface.h5", size=(3e-6, 4e-6), height_unit="um")


def stated(**options):
    return STATED.model_copy(update=options)


@pytest.fixture
def h5py():
    return pytest.importorskip("h5py")


@pytest.fixture
def written(h5py, tmp_path):
    def write(**datasets):
        path = tmp_path / "surface.h5"
        with h5py.File(path, "w") as file:
            for name, values in datasets.items():
                file.create_dataset(name, data=values)
        return path

    return write


def test_only_the_crop_of_the_only_map_is_read(written):
    """Micrometres become metres; the first index runs along x; other datasets are no maps."""
    path = written(surface=HEIGHTS, seeds=np.arange(5))
    part = read_heights(path, stated(crop=(1, 1, 2, 2)))
    np.testing.assert_allclose(part.heights, 1e-6 * HEIGHTS[1:3, 1:3], rtol=1e-15)
    assert part.size == pytest.approx((2e-6, 2e-6))


def test_a_channel_chooses_among_several_maps(written):
    path = written(first=HEIGHTS, second=2 * HEIGHTS)
    with pytest.raises(FileError, match=r"expected one map, the .* are 'first', 'second'"):
        read_heights(path, STATED)
    second = read_heights(path, stated(channel="second"))
    assert second.heights[0, 1] == pytest.approx(2e-6)


@pytest.mark.parametrize(
    ("datasets", "surface", "problem"),
    [
        ({"surface": HEIGHTS}, stated(size=None), "size is needed: a dataset of an HDF5 file"),
        ({"seeds": np.arange(5)}, STATED, "expected one map, .* are none"),
        ({"surface": HEIGHTS + 1j}, STATED, "real numbers"),
    ],
)
def test_what_is_no_map_is_refused_with_the_reason(written, datasets, surface, problem):
    with pytest.raises(FileError, match=problem):
        read_heights(written(**datasets), surface)


@pytest.mark.usefixtures("h5py")
def test_a_text_is_no_hdf5(tmp_path):
    (tmp_path / "surface.h5").write_text("0 1\n2 3\n")
    with pytest.raises(FileError, match="not a readable HDF5 file"):
        read_heights(tmp_path / "surface.h5", STATED)


def test_a_link_to_another_file_is_no_map(h5py, written, tmp_path):
    """A file from elsewhere must not open others of this machine."""
    written(surface=HEIGHTS)
    with h5py.File(tmp_path / "link.h5", "w") as file:
        file["surface"] = h5py.ExternalLink("surface.h5", "surface")
    with pytest.raises(FileError, match="are none"):
        read_heights(tmp_path / "link.h5", STATED)


def test_a_map_inside_groups_is_found_and_never_passed_over_for_another(h5py, tmp_path):
    """A map in a group used to be overlooked: beside another one, that one was taken unasked."""
    path = tmp_path / "surface.h5"
    with h5py.File(path, "w") as file:
        file["run/heights"] = HEIGHTS
        file["run/again"] = file["run"]  # a circle
    assert read_heights(path, STATED).heights.shape == HEIGHTS.shape
    with h5py.File(path, "a") as file:
        file["other"] = HEIGHTS
    with pytest.raises(FileError, match=r"expected one map, .* are 'other', 'run/heights'"):
        read_heights(path, STATED)
