"""The convolution against transforms and direct sums, the solver's stages, continued fields."""

import os
import pickle
import subprocess
import sys
import threading
import time
import tracemalloc

import numpy as np
import pytest
import scipy.fft
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from reference import surfaces
from reference.contact import descent, pieces
from reference.contact import press as pressing
from reference.contact.body import Convolution
from reference.contact.extension import Extension
from reference.contact.press import press
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.loads import Load
from reference.surfaces import SelfAffine, self_affine

# Powers and mixtures of small factors, primes (by chirps), single rows and columns.
LENGTHS = st.sampled_from([1, 2, 3, 4, 5, 7, 8, 9, 11, 15, 16, 17, 24, 30, 31, 32, 40, 49, 64, 97])
PADDING = st.sampled_from([0, 1, 5])


def even_transfer(padded: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Random transfer function, even in both wavenumbers."""
    mirrored = [np.minimum(np.arange(n), n - np.arange(n)) for n in padded]
    kernel = rng.standard_normal([n // 2 + 1 for n in padded])[np.ix_(*mirrored)]
    return scipy.fft.rfft2(kernel).real


@settings(max_examples=60, deadline=None)
@given(
    shape=st.tuples(LENGTHS, LENGTHS),
    padding=st.tuples(PADDING, PADDING),
    dtype=st.sampled_from([np.float32, np.float64]),
    seed=st.integers(0, 1000),
)
def test_convolution_is_that_of_plain_transforms_in_both_precisions(shape, padding, dtype, seed):
    """Error relative to the largest value: transforms of n points lose about log2(n) roundings."""
    rng = np.random.default_rng(seed)
    padded = (shape[0] + padding[0], shape[1] + padding[1])
    transfer = even_transfer(padded, rng)
    field = rng.standard_normal(shape).astype(dtype)
    spectrum = scipy.fft.rfft2(field.astype(float), s=padded) * transfer
    expected = scipy.fft.irfft2(spectrum, s=padded)[: shape[0], : shape[1]]
    result = Convolution(shape, padded, transfer, dtype)(field)
    assert result.dtype == dtype
    scale = np.abs(transfer).max() * np.linalg.norm(field)
    assert np.abs(result - expected).max() <= 4 * np.finfo(dtype).eps * scale


@pytest.mark.parametrize("shape", [(8, 8), (13, 22), (20, 24), (1, 37)])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_convolution_on_the_free_half_space_is_the_sum_over_all_pairs_of_cells(shape, dtype):
    """u_i = sum_j K_ij p_j with Love's coefficients, added up directly; rounding of one sum."""
    operator = FreeOperator(shape, (1.0, 0.7), 2.0)
    pressure = np.random.default_rng(4).random(shape)
    rows, columns = (np.arange(n) for n in shape)
    offsets = np.ix_(*(abs(np.subtract.outer(k, k)).ravel() for k in (rows, columns)))
    pairs = operator.coefficients(shape)[offsets].reshape(*2 * shape[:1], *2 * shape[1:])
    expected = np.einsum("iajb,ab->ij", pairs, pressure)
    result = operator.unit * operator.convolution(dtype)(pressure.astype(dtype))
    np.testing.assert_allclose(result, expected, rtol=20 * np.finfo(dtype).eps)


def test_a_convolution_leaves_its_field_alone_and_remembers_nothing():
    """Transforms overwrite what they may: the same field gives the same bits after another one."""
    rng = np.random.default_rng(1)
    operator = FreeOperator((13, 22), (1.0, 1.0), 1.0)
    first, second = rng.random((2, 13, 22))
    kept = first.copy()
    before = operator.apply(first)
    operator.apply(second)
    np.testing.assert_array_equal(operator.apply(first), before)
    np.testing.assert_array_equal(first, kept)


def test_operators_travel_between_processes_without_their_work_memory():
    operator = PeriodicOperator((64, 64), (1.0, 2.0), 3.0, kernel="cells")
    pressure = np.random.default_rng(2).random((64, 64))
    displacement = operator.apply(pressure)
    packed = pickle.dumps(operator)
    assert len(packed) < 1000
    np.testing.assert_array_equal(pickle.loads(packed).apply(pressure), displacement)


def problem(operator_class):
    height = gaussian_filter(np.random.default_rng(3).standard_normal((48, 40)), 1.5, mode="wrap")
    return operator_class((48, 40), (1.0, 1.0), 1.0), height.max() - height


@pytest.mark.parametrize("operator_class", [FreeOperator, PeriodicOperator])
def test_a_preconditioner_that_misleads_is_given_up(operator_class, monkeypatch):
    """With |q| replaced by its sixth power both preconditioned stages stall; the plain one ends."""
    operator, gap = problem(operator_class)
    usual = press(operator, gap, Load("force", 20.0))
    sound = descent._preconditioner

    def misleading(operator, dtype):
        made = sound(operator, dtype)
        return Convolution(
            made.shape, made.padded, 1e-3 + np.hypot(*wavenumbers(made.padded)) ** 6, dtype
        )

    def wavenumbers(padded):
        return np.fft.fftfreq(padded[0])[:, None], np.fft.rfftfreq(padded[1])[None, :]

    monkeypatch.setattr(descent, "_preconditioner", misleading)
    contact = press(operator, gap, Load("force", 20.0))
    assert contact.violation <= 1e-8
    assert contact.iterations > 2 * usual.iterations
    assert contact.penetration == pytest.approx(usual.penetration, rel=1e-7)


def test_a_field_out_of_the_range_of_numbers_is_an_error():
    """A gap near the largest double overflows: the solver says so and returns no NaN."""
    gap = np.array([[0.0, 1.0], [1.0, 1e300]]) * 1e8
    with pytest.raises(ConvergenceError, match="range of numbers"):
        press(FreeOperator((2, 2), (1.0, 1.0), 1e-300), gap, Load("force", 1e308))


@pytest.mark.parametrize(("padding", "dtype"), [(0, np.float32), (0, np.float64), (26, np.float64)])
def test_large_fields_are_convolved_in_blocks_with_the_same_result(padding, dtype, monkeypatch):
    """Blocks of a few rows and columns, shared by threads or not, into the field itself."""
    rng = np.random.default_rng(7)
    shape = (60, 46)
    padded = (shape[0] + padding, shape[1] + padding)
    transfer, field = even_transfer(padded, rng), rng.standard_normal(shape).astype(dtype)
    whole = Convolution(shape, padded, transfer, dtype)(field)
    monkeypatch.setattr("reference.contact.body._ONE_BLOCK", 0)
    monkeypatch.setattr(pieces, "SIZE", 500)
    blocks = Convolution(shape, padded, transfer, dtype)
    alone = blocks(field)
    np.testing.assert_allclose(alone, whole, atol=20 * np.finfo(dtype).eps * abs(whole).max())
    with pieces.threads(2):
        shared = blocks(field.copy(), out=field)
    assert shared is field
    np.testing.assert_array_equal(shared, alone)


@pytest.mark.parametrize("one_block", [0, 10**9])
def test_fields_of_another_shape_are_refused_and_other_precisions_cast(one_block, monkeypatch):
    monkeypatch.setattr("reference.contact.body._ONE_BLOCK", one_block)
    rng = np.random.default_rng(9)
    padded = (16, 512)
    convolve = Convolution((10, 20), padded, even_transfer(padded, rng), np.float32)
    field = rng.standard_normal((10, 20)).astype(np.float32)
    for shape in ((5, 20), (10, 100), (200,)):
        with pytest.raises(ValueError, match=r"shape \(10, 20\)"):
            convolve(np.ones(shape, np.float32))
        with pytest.raises(ValueError, match=r"shape \(10, 20\)"):
            convolve(field, np.empty(shape, np.float32))
    double = convolve(field, np.empty((10, 20)))
    assert double.dtype == np.float64
    np.testing.assert_array_equal(double, convolve(field))
    np.testing.assert_array_equal(convolve(field.astype(float)), double)


def test_an_error_in_one_piece_ends_the_others():
    """The other thread is in a piece of its own by then, and takes at most a few more."""
    failed, done = threading.Event(), []

    def work(part):
        if part.start == 0:
            failed.set()
            raise ValueError("piece 0")
        failed.wait()
        time.sleep(1e-3)
        done.append(part.start)

    with pieces.threads(2), pytest.raises(ValueError, match="piece 0"):
        pieces.over(2000, 1, work)
    assert len(done) < 1000


def test_results_do_not_depend_on_the_number_of_threads(monkeypatch):
    """Pieces of 500 cells, so that the sums of a small grid are of several parts."""
    monkeypatch.setattr("reference.contact.body._ONE_BLOCK", 0)
    monkeypatch.setattr(pieces, "SIZE", 500)
    operator, gap = problem(PeriodicOperator)
    alone = press(operator, gap, Load("force", 20.0))
    with pieces.threads(2):
        shared = press(operator, gap, Load("force", 20.0))
    np.testing.assert_array_equal(shared.pressure, alone.pressure)
    assert shared.history == alone.history


def peak_bytes(operator, gap):
    """Largest sum of arrays that a solve holds beside the gap, per cell."""
    tracemalloc.start()
    press(operator, gap, Load("force", 0.003))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / gap.size + gap.itemsize


@pytest.mark.slow
@pytest.mark.parametrize(("operator_class", "most"), [(PeriodicOperator, 64), (FreeOperator, 128)])
def test_a_solve_holds_no_more_arrays_than_its_plan_says(operator_class, most, monkeypatch):
    """Bytes per cell from the operator to the answer, the gap included; pieces count little."""
    monkeypatch.setattr("reference.contact.body._ONE_BLOCK", 0)
    monkeypatch.setattr(pieces, "SIZE", 2**12)
    n = 256
    spectrum = SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=16 / n)
    height = self_affine(n, 1.0, spectrum, seed=1, realisation=0)
    gap = height.max() - height
    once, again = (operator_class((n, n), (1 / n, 1 / n), 1.0) for _ in range(2))
    peak_bytes(once, gap)  # compiles
    assert peak_bytes(again, gap) <= most


@pytest.mark.parametrize(
    ("shape", "period"),
    [((16, 16), (16, 16)), ((7, 9), (7, 9)), ((12, 20), (17, 23)), ((1, 5),) * 2],
)
def test_restriction_is_the_transpose_of_extension(shape, period):
    """r.E^T y = E r.y to rounding: conjugate gradients need a symmetric preconditioner."""
    random = np.random.default_rng(1)
    inside = (random.random(shape) < 0.2).astype(np.uint8)
    inside[0, 0] = 1
    values, field = random.random(shape) * inside, random.random(period)
    extension = Extension(period, np.float64)
    extended = extension.extend(values, inside, np.empty(period))
    restricted = extension.restrict(field, inside, np.empty(shape))
    assert np.vdot(extended, field) == pytest.approx(np.vdot(values, restricted), rel=1e-13)
    assert not restricted[inside == 0].any()
    # as a mean of means, and unchanged on the contact
    assert extended.max() <= values.max() * (1 + 1e-12)
    assert np.allclose(extended[: shape[0], : shape[1]][inside > 0], values[inside > 0], rtol=1e-14)


DIGITS = """
import numpy as np
from reference.contact.extension import Extension
stream = np.random.default_rng(1)
contact = (stream.random((24, 30)) < 0.2).astype(np.uint8)
extension = Extension((31, 33), np.float64)
extension.extend(stream.random(contact.shape) * contact, contact, np.empty((31, 33)))
print(extension.restrict(stream.random((31, 33)), contact, np.empty(contact.shape)).tobytes().hex())
"""


@pytest.mark.slow
def test_a_process_that_compiles_has_the_digits_of_one_that_loads_its_code(tmp_path):
    """What LLVM inlines must not hang on the cache: a descent's digits would, too."""
    compiled, loaded = (
        subprocess.run(
            [sys.executable, "-c", DIGITS],
            env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for _ in range(2)
    )
    assert compiled == loaded != ""


@pytest.mark.parametrize("operator_class", [PeriodicOperator, FreeOperator])
def test_convolutions_do_not_grow_with_the_grid(operator_class):
    """Four times the points a side, of the same waves in cells, take as many convolutions.

    By zeros in place of the extension they took 44 and 51 (free), 48 and 46 (periodic).
    """
    single = []
    for points in (96, 384):
        waves = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=16 / points)
        heights = surfaces.self_affine((points, points), (1.0, 1.0), waves, seed=1, realisation=0)
        operator = operator_class(heights.shape, (1 / points, 1 / points), 1.0)
        load = Load("force", 0.225 * 0.1 / 2)
        contact = press(operator, heights.max() - heights, load, tolerance=1e-8)
        assert contact.convolutions[1] <= 3
        single.append(contact.convolutions[0])
    assert max(single) <= 34
    assert single[1] <= 1.3 * single[0]


@pytest.mark.slow
@pytest.mark.parametrize("shape", [(8192, 256), (16384, 128)])
def test_long_periods_take_as_many_convolutions_as_short_ones(shape):
    """512 and 1024 shortest waves along one side: coarser grids are solved to what waves need.

    Where all grids stopped at 1 % of the penetration, which grows with the period, the finest got
    the errors of four: 37 and 99 convolutions. Where directions were kept across changes of the
    contact, 20 and 38.
    """
    step = 1 / shape[0]
    waves = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=16 * step)
    lengths = (1.0, shape[1] * step)
    heights = surfaces.self_affine(shape, lengths, waves, seed=1, realisation=0)
    body = PeriodicOperator(shape, (step, step), 1.0)
    load = Load("force", 0.225 * 0.1 / 2 * lengths[1])
    contact = press(body, heights.max() - heights, load, tolerance=1e-8)
    assert contact.convolutions[0] <= 25


def test_a_coarser_grid_that_misses_its_tolerance_is_still_a_start(monkeypatch):
    """One iteration on each coarser grid leaves most of what they save beside the overlap."""
    points = 256
    waves = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=4 / points)
    heights = surfaces.self_affine((points, points), (1.0, 1.0), waves, seed=1, realisation=0)
    body = PeriodicOperator(heights.shape, (1 / points,) * 2, 1.0)
    gap, load = heights.max() - heights, Load("force", 0.225 * 0.1 / 2)

    def violation() -> float:
        return press(body, gap, load, tolerance=1e-8).history[0]

    with monkeypatch.context() as patch:
        patch.setattr(pressing, "SHORTEST_COARSENED", 2 * points)
        overlap = violation()
    monkeypatch.setattr(pressing, "_COARSE_ITERATIONS", 1)
    assert violation() < overlap / 2
