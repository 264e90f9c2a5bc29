"""What a user of the library meets: supports, loads, paths, solvers, and refusals in words."""

import numpy as np
import pytest

from shells.conditions.loads import end_moment, follower_pressure, line_load, point_load
from shells.conditions.supports import clamp, hinge, pin, supported, symmetry
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.equilibrium.load_paths import load_path, static_path
from shells.equilibrium.minimise import minimise
from shells.equilibrium.multigrid import multigrid
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.splines import SplineSpace
from shells.surfaces.surface_basis import SurfaceBasis


def plate(n=8, m=4, length=4.0, bulge=0.0, degree=3, start=0.0, rigidity=1e-2):
    s = SplineSpace(np.linspace(0.0, length, n + 1), degree)
    t = SplineSpace(np.linspace(start, 1.0, m + 1), degree)
    surface = SplineSurface(s, t)
    x, y = np.repeat(s.greville, t.n), np.tile(t.greville, s.n)
    c = np.stack([x, y, bulge * x * (length - x)], axis=1)
    return (
        surface,
        c,
        KirchhoffLove(SurfaceBasis(surface, c), Material(rigidity, poisson_ratio=0.3)),
    )


def test_symmetry_plane_gives_the_whole_answer():
    """Half a cantilever cut along its length carries half the load and bends the same."""
    tips = []
    for start, rows in ((0.0, 4), (0.5, 2)):
        surface, c, shell = plate(m=rows, start=start)
        supports = [clamp(surface, "s", 0, (2,))]
        if start:
            supports.append(symmetry(surface, "t", 0, axis=1))
        structure = ShellStructure(shell, supported(surface, *supports))
        load = line_load(surface, "s", 1, np.array([0.0, 0.0, 2e-4]), c)
        step = structure.static(c, load=load)
        assert step.ok
        tips.append(step.state.coefficients[surface.ring(-1)][-1])
    # not to rounding: the odd component is C2 across the middle of the whole, C1 at the plane
    assert tips[1] == pytest.approx(tips[0], abs=1e-7)


def test_two_symmetry_planes_meet_in_a_corner():
    """A quarter of a hinged plate under a point load on its middle against the whole."""
    lifts = []
    for quarter in (False, True):
        s = SplineSpace(np.linspace(0.0, 1.0, 5), 3)
        whole = SplineSpace(np.linspace(-1.0, 1.0, 9), 3)
        space = s if quarter else whole
        surface = SplineSurface(space, space)
        x = np.repeat(space.greville, space.n), np.tile(space.greville, space.n)
        c = np.stack([*x, 0.0 * x[0]], axis=1)
        shell = KirchhoffLove(SurfaceBasis(surface, c), Material(1e-2))
        edges = [hinge(surface, d, 1) for d in "st"]
        if quarter:
            edges += [symmetry(surface, d, 0, axis) for axis, d in enumerate("st")]
        else:
            edges += [hinge(surface, d, 0) for d in "st"]
        load = point_load(surface, 0.0, 0.0, [0.0, 0.0, 2.5e-3 if quarter else 1e-2])
        assert load.sum() == pytest.approx(2.5e-3 if quarter else 1e-2)
        step = ShellStructure(shell, supported(surface, *edges)).static(c, load=load)
        assert step.ok
        middle = np.outer(space.evaluate(0.0)[0], space.evaluate(0.0)[0]).ravel()
        lifts.append(middle @ step.state.coefficients[:, 2])
    # 2.7e-5 softer: the quarter's odd components may bend at the planes, the whole's are C2
    assert lifts[1] == pytest.approx(lifts[0], rel=5e-5)


@pytest.mark.parametrize("kind", ["pressure", "moment"])
def test_following_loads_by_finite_differences(kind):
    surface, c, shell = plate(3, 2, bulge=0.1)
    load = follower_pressure(shell.basis, 0.7)
    if kind == "moment":
        load = end_moment(surface, "s", 1, 0.7, c)
    rng = np.random.default_rng(3)
    x, d = c + 0.05 * rng.standard_normal(c.shape), rng.standard_normal(c.shape)
    step = 1e-6
    slope = (load(x + step * d)[0] - load(x - step * d)[0]).ravel() / (2.0 * step)
    exact = load(x)[1] @ d.ravel()
    assert np.linalg.norm(slope - exact) < 1e-8 * np.linalg.norm(exact)


def test_follower_pressure_on_a_closed_surface_is_the_volume_gradient():
    from cases.geometry.revolution import sphere

    surface, c = sphere(3, 5, 8)
    basis = SurfaceBasis(surface, c, points=5)
    force = follower_pressure(basis, 2.0)(c)[0]
    full = 2.0 * surface.reduction.T @ EnclosedVolume(basis).gradient(c).reshape(-1, 3)
    # the short form equals the full one up to quadrature, exactly from (3 p + 1) / 2 points on
    assert surface.reduction.T @ force == pytest.approx(full, abs=1e-14)


def test_mechanisms_are_named_before_assembly():
    surface, c, shell = plate()
    down = point_load(surface, 4.0, 1.0, [0.0, 0.0, -1e-4])
    hinged = ShellStructure(shell, supported(surface, hinge(surface, "s", 0)))
    with pytest.raises(ValueError, match=r"1 rigid motion\(s\) free.*rotation about y.*minimise"):
        hinged.static(c, load=down)
    free = ShellStructure(shell, supported(surface, pin(surface, 0)))
    with pytest.raises(ValueError, match=r"3 rigid motion\(s\) free"):
        free.static(c, load=down)
    assert free.mechanism.motions.shape == (3, 6)
    ok = ShellStructure(shell, supported(surface, hinge(surface, "s", 0), hinge(surface, "s", 1)))
    assert ok.mechanism.motions.shape[0] == 0
    with pytest.raises(ValueError, match="encloses no volume"):
        ok.static(c, volume=1.0)


def test_loads_on_nothing_are_named():
    surface, c, shell = plate()
    with pytest.raises(ValueError, match=r"s = 5 acts on no element: s runs from 0 to 4"):
        point_load(surface, 5.0, 0.5, [0.0, 0.0, 1.0])
    part = surface.restrict(np.arange(8))
    with pytest.raises(ValueError, match="acts on no element of this restriction"):
        point_load(part, 3.9, 0.5, [0.0, 0.0, 1.0])
    with pytest.raises(ValueError, match="no element has an edge at the end of 's'"):
        line_load(part, "s", 1, np.ones(3), c[part.kept])
    structure = ShellStructure(shell, supported(surface, clamp(surface, "s", 0)))
    with pytest.raises(ValueError, match="supported coefficients only"):
        structure.static(c, load=line_load(surface, "s", 0, np.ones(3), c))


def test_bad_surfaces_are_named():
    with pytest.raises(ValueError, match=r"breaks\[2\] = 0.5 follows 0.7"):
        SplineSpace([0.0, 0.7, 0.5, 1.0], 3)
    with pytest.raises(ValueError, match=r"knots\[5\] = 0.2 follows 0.6"):
        SplineSpace.from_knots([0, 0, 0, 0, 0.6, 0.2, 1, 1, 1, 1], 3)
    with pytest.raises(ValueError, match="4 fold ends"):
        SplineSpace.from_knots([0, 0, 0, 1, 1, 1], 3)
    space = SplineSpace.from_knots([0, 0, 0, 0.5, 0.5, 1, 1, 1], 2)
    assert (space.n, space.multiplicity[1]) == (5, 2)
    surface, c, _ = plate()
    c[surface.ring(3), 1] = c[surface.ring(2), 1] = 0.0
    c[surface.ring(4), 1] = c[surface.ring(5), 1] = 0.0
    with pytest.raises(ValueError, match=r"4 element\(s\).*degenerate.*element \(2, 0\) near"):
        SurfaceBasis(surface, c)


def test_failed_path_keeps_its_last_state_and_says_why():
    """A shallow arch snaps through: a load path must stop at its limit point."""
    surface, c, shell = plate(8, 1, bulge=0.05, rigidity=1e-5)
    edges = [hinge(surface, "s", end) for end in (0, 1)]
    structure = ShellStructure(shell, supported(surface, *edges), max_iterations=8)
    force = line_load(surface, "t", 0, np.array([0.0, 0.0, -1.0]), c)
    force += line_load(surface, "t", 1, np.array([0.0, 0.0, -1.0]), c)
    path = load_path(structure, c, lambda f: f * 1e-2 * force, [0.01, 0.1, 1.0])
    assert not path.ok
    assert 0.0 < path.parameter < 1.0
    assert f"stopped at {path.parameter:.6g}" in path.failure
    assert "residual" in path.failure
    assert "remedy" in path.failure
    r = structure.shell.gradient(path.state.coefficients) - path.parameter * 1e-2 * force.ravel()
    assert np.abs(structure.E.T @ r).max() < 1e-7 * np.abs(force).max()
    failed = structure.static(c, load=force)
    assert not failed.ok
    assert np.array_equal(failed.state.coefficients, c)
    # the descent passes it
    end = minimise(structure, c, load=1e-2 * force)
    assert end.ok
    assert end.state.coefficients[:, 2].min() < -0.1


def test_kept_factors_and_multigrid_reach_the_same_state():
    surface, c, shell = plate(8, 4, bulge=0.05)
    E = supported(surface, hinge(surface, "s", 0), hinge(surface, "s", 1))
    load = point_load(surface, 1.0, 0.3, [0.0, 0.0, -1e-3])
    newton = ShellStructure(shell, E).static(c, load=load)
    kept = ShellStructure(shell, E, reuse=0.5).static(c, load=load)
    amg = ShellStructure(shell, E, solver=multigrid(c, E, tolerance=1e-11)).static(c, load=load)
    assert kept.factorizations < newton.factorizations
    for other in (kept, amg):
        assert other.ok
        assert other.state.coefficients == pytest.approx(newton.state.coefficients, abs=1e-8)


def test_path_of_volumes_with_kept_factors():
    """A dome on a hinged rim: both iterations end at one pressure, the volume is exact."""
    t = SplineSpace(np.linspace(0, 2 * np.pi, 13), 3, periodic=True)
    s = SplineSpace(np.linspace(0, 1, 5), 3)
    dome = SplineSurface(s, t, pole_start=True)
    r, a = np.repeat(s.greville, t.n), np.tile(t.greville, s.n)
    c = np.stack([r * np.cos(a), r * np.sin(a), 0.1 * (1 - r**2)], axis=1)
    c[: t.n, 2] = c[t.n : 2 * t.n, 2]
    basis = SurfaceBasis(dome, c)
    shell = KirchhoffLove(basis, Material(1e-3))
    pressures = []
    for reuse in (0.0, 0.5):
        structure = ShellStructure(
            shell, supported(dome, hinge(dome, "s", 1)), EnclosedVolume(basis), reuse=reuse
        )
        start = structure.volume(c)
        path = static_path(structure, c, start * np.array([1.1, 1.2, 1.4]))
        assert path.ok
        assert structure.volume(path.state.coefficients) == pytest.approx(1.4 * start, rel=1e-12)
        pressures.append(path.state.pressure)
    assert pressures[1] == pytest.approx(pressures[0], rel=1e-8)


def test_resultants_and_files_of_a_stretched_strip(tmp_path):
    """Uniaxial tension: n = E h e with e = (l^2 - 1) / 2, and both stretches."""
    import meshio

    from cases.output.shell_fields import write_shell
    from shells.energy.stress import stress

    _, c, shell = plate(4, 2)
    stretched = c * [1.1, 1.0, 1.0]
    e = 0.5 * (1.1**2 - 1.0)
    found = stress(shell, stretched)
    assert found.membrane[..., :2] == pytest.approx(np.broadcast_to([e, 0.3 * e], (8, 16, 2)))
    assert found.stretches == pytest.approx(np.broadcast_to([1.1, 1.0], (8, 16, 2)))
    write_shell(tmp_path / "strip.vtu", shell, stretched, tessellate=2)
    mesh = meshio.read(tmp_path / "strip.vtu")
    assert mesh.points.shape == (8 * 9, 3)
    assert mesh.points[:, 0].max() == pytest.approx(4.4)
    assert mesh.point_data["displacement"][:, 0].max() == pytest.approx(0.4)
    assert mesh.cell_data["stretch"][0][:, 0] == pytest.approx(np.full(32, 1.1))


def test_the_package_example():
    import doctest

    import shells

    assert doctest.testmod(shells).failed == 0
    assert shells.minimise is minimise  # what messages advise is a name of the package
