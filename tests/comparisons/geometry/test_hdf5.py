"""Maps in HDF5 files, as the Contact Mechanics Challenge publishes them."""

import numpy as np
import pytest

from comparisons.geometry.map_files.heights import read_heights
from comparisons.geometry.reading import FileError
from comparisons.scene.surface import MeasuredMap

h5py = pytest.importorskip("h5py")
HEIGHTS = np.arange(12.0).reshape(3, 4)
STATED = MeasuredMap(kind="map", file="surface.h5", size=(3e-6, 4e-6), height_unit="um")


def stated(**options):
    return STATED.model_copy(update=options)


@pytest.fixture
def written(tmp_path):
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


def test_a_link_to_another_file_is_no_map(written, tmp_path):
    """A file from elsewhere must not open others of this machine."""
    written(surface=HEIGHTS)
    with h5py.File(tmp_path / "link.h5", "w") as file:
        file["surface"] = h5py.ExternalLink("surface.h5", "surface")
    with pytest.raises(FileError, match="are none"):
        read_heights(tmp_path / "link.h5", STATED)


def test_a_map_inside_groups_is_found_and_never_passed_over_for_another(tmp_path):
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


def test_a_file_that_is_no_hdf5_is_refused(tmp_path):
    (tmp_path / "surface.h5").write_text("0 1\n2 3\n")
    with pytest.raises(FileError, match="not a readable HDF5 file"):
        read_heights(tmp_path / "surface.h5", STATED)
