"""Two runs at equal volumes: points between frames, figures between rows."""

import numpy as np
import pytest

from cases.kinds.inflation.views.animation import at_even_times
from cases.kinds.inflation.views.equal_volumes import RunByVolume, common_volumes, largest_excess
from cases.kinds.inflation.views.loads import loads
from cases.kinds.inflation.views.picture import BagShot, enclosed_volume
from cases.output.figures import NoPicture
from cases.output.history import History
from cases.output.vtk import write_frames, write_grid

CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
QUADS = np.array(
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
)


def boxes(folder, sides, angles=None, loaded=False):
    """A run of cubes of given sides, ten units of time apart."""
    folder.mkdir()
    frames, history = [], History(folder / "history.csv")
    for k, side in enumerate(sides):
        data = {"traction": np.full((8, 3), float(k))}
        grid = {"points": CORNERS * side - 0.5 * side, "quads": QUADS}
        zones = {}
        if loaded:
            data["contact_pressure"] = np.where(CORNERS[:, 2] > 0.0, side - 1.0, 0.0)
            zones = {"wrinkling": np.array([0, 0, 1, 0, 2, 0])}
        name = f"fields/frame_{k:06d}.vtu"
        write_grid(folder / name, {**grid, "point_data": data, "cell_data": zones})
        frames.append((10.0 * k, name))
        angle = {} if angles is None else {"panel_angle": angles[k]}
        row = {"step": k, "t": 10.0 * k, "volume": side**3, "pressure": 0.1 * side}
        history.append({**row, **angle})
    write_frames(folder / "fields.pvd", frames)
    return RunByVolume.of(folder)


def test_volume_of_a_box():
    assert enclosed_volume(CORNERS * [2.0, 3.0, 4.0] + 7.0, QUADS) == pytest.approx(24.0, rel=1e-14)


def test_shots_enclose_the_volume_asked_for(tmp_path):
    """Sides grow linearly between frames, volumes as their cubes."""
    run = boxes(tmp_path / "a", [1.0, 2.0, 3.0])
    for volume in (1.0, 2.0, 8.0, 20.0, 27.0):
        shot = run.at(volume)
        assert enclosed_volume(shot.points, shot.quads) == pytest.approx(volume, rel=1e-9)
        assert shot.points.max() == pytest.approx(0.5 * volume ** (1.0 / 3.0), rel=1e-9)
    share = 2.0 ** (1.0 / 3.0) - 1.0
    np.testing.assert_allclose(run.at(2.0).values, share * np.sqrt(3.0), rtol=1e-9)
    with pytest.raises(NoPicture, match="no frames about"):
        run.at(28.0)


def test_columns_are_read_where_a_volume_is_first_reached(tmp_path):
    run = boxes(tmp_path / "a", [1.0, 2.0, 2.0, 3.0], angles=[90.0, 60.0, 10.0, 0.0])
    found = run.figure("panel_angle", np.array([4.5, 8.0, 17.5, 30.0]))
    np.testing.assert_allclose(found, [75.0, 60.0, 30.0, np.nan])
    assert np.isnan(run.figure("absent", np.ones(2))).all()


def test_volumes_are_even_on_the_range_in_common(tmp_path):
    first, second = boxes(tmp_path / "a", [1.0, 3.0]), boxes(tmp_path / "b", [1.0, 1.5, 2.0])
    np.testing.assert_allclose(common_volumes(first, second, 7), np.arange(2.0, 9.0))
    with pytest.raises(NoPicture, match="no growing volume"):
        common_volumes(first, boxes(tmp_path / "c", [1.0, 1.0]), 5)


def test_largest_excess_is_taken_at_equal_volume(tmp_path):
    first = boxes(tmp_path / "a", [1.0, 2.0, 3.0], angles=[90.0, 80.0, 20.0])
    second = boxes(tmp_path / "b", [1.0, 2.0, 2.5], angles=[90.0, 65.0, 60.0])
    excess, volume = largest_excess(first, second)
    assert volume == 8.0
    assert excess == pytest.approx(15.0)
    assert np.isnan(largest_excess(first, boxes(tmp_path / "c", [1.0, 2.0]))[0])


def test_a_movie_shows_even_times():
    """Steps of 8, 1 and 1 become three of 10/3."""
    shots = [BagShot(t, CORNERS * t, QUADS, np.full(8, 2.0 * t)) for t in (0.0, 8.0, 9.0, 10.0)]
    shown = list(at_even_times(shots))
    np.testing.assert_allclose([shot.t for shot in shown], [0.0, 10 / 3, 20 / 3, 10.0])
    for shot in shown:
        np.testing.assert_allclose(shot.points, CORNERS * shot.t, atol=1e-14)
        np.testing.assert_allclose(shot.values, 2.0 * shot.t, atol=1e-14)


def test_loads_are_drawn_where_frames_carry_them(tmp_path):
    boxes(tmp_path / "a", [1.0, 2.0, 3.0], loaded=True)
    assert loads(tmp_path / "a").read_bytes()[:4] == b"\x89PNG"
    boxes(tmp_path / "b", [1.0, 2.0])
    with pytest.raises(NoPicture, match="without contact and wrinkles"):
        loads(tmp_path / "b")
