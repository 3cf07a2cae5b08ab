"""The rolling simulation against MuJoCo, which knows nothing of rolling: only contact forces with friction.

MuJoCo's contacts are soft: the body sinks in a little and creeps against friction, in proportion to the time
constant of the contact. So its motion must converge to the one without slip as that constant goes to zero.
Where its contact with a plane is exact, on an ellipsoid, it does. Of a mesh it sees the facets: the body
rocks over their corners, which takes energy and holds it in places where the smooth body rolls on. So on a
mesh the two agree at first, the better the finer it is, and not until rest.
"""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from gomboc_cad.body.sphere import Array, geodesic_triangulation
from gomboc_cad.dynamics import RollingBody, Trajectory, roll
from gomboc_cad.dynamics.contact import turned

SCENE = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -9.80665" integrator="RK4" cone="elliptic" impratio="100"
          tolerance="1e-14" iterations="200"/>
  <default><geom condim="3" friction="5 0 0" solref="{constant} 1" solimp="0.99 0.9999 1e-5"/></default>
  <asset>{mesh}</asset>
  <worldbody>
    <geom type="plane" size="5 5 1"/>
    <body>
      <freejoint/>
      <inertial pos="{com}" mass="1" fullinertia="{inertia}"/>
      <geom {shape}/>
    </body>
  </worldbody>
</mujoco>
"""


def numbers(values: Array) -> str:
    return " ".join(f"{value:.12g}" for value in np.ravel(values))


def down_in_mujoco(
    mujoco: ModuleType,
    rolling: RollingBody,
    motion: Trajectory,
    shape: str,
    constant_s: float,
    *,
    step_s: float,
    mesh: str = "",
) -> Array:
    """Body directions that point down at the instants of a motion from rest, in metres and kilograms."""
    inertia, com = 1e-6 * np.array(rolling.gyration_mm2), np.array(rolling.com_mm)
    upper = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    scene = SCENE.format(
        step=step_s,
        constant=constant_s,
        mesh=mesh,
        shape=shape,
        com=numbers(1e-3 * com),
        inertia=numbers(upper),
    )
    model = mujoco.MjModel.from_xml_string(scene)
    data = mujoco.MjData(model)
    x, y, z, w = motion.turn[0]
    data.qpos[:3] = 1e-3 * (motion.com_mm[0] - turned(motion.turn[:1], com[None])[0])
    data.qpos[3:] = w, x, y, z
    stride = round((motion.times_s[1] - motion.times_s[0]) / step_s)
    down = np.empty_like(motion.down)
    for k in range(len(down)):
        mujoco.mj_forward(model, data)
        down[k] = -data.xmat[1].reshape(3, 3)[2]
        for _ in range(stride):
            mujoco.mj_step(model, data)
    return down


def degrees_apart(one: Array, other: Array) -> Array:
    return np.degrees(2.0 * np.arcsin(0.5 * np.linalg.norm(one - other, axis=1)))


def test_an_ellipsoid_converges_to_rolling_as_its_contact_stiffens(
    mujoco: ModuleType, loaded_ellipsoid: RollingBody
) -> None:
    """Two seconds, four swings of up to 33° about two axes at once with the periods 0.47 and 0.33 s."""
    axes = numbers(1e-3 * 50.0 * np.array([1.3, 1.0, 0.8]))
    motion = roll(loaded_ellipsoid, (0.5, 0.4, -1.0), duration_s=2.0, samples=41, tolerance=1e-9)
    assert motion.stays_on_table
    errors = [
        degrees_apart(
            down_in_mujoco(
                mujoco,
                loaded_ellipsoid,
                motion,
                f'type="ellipsoid" size="{axes}"',
                constant,
                step_s=0.2 * constant,
            ),
            motion.down,
        ).max()
        for constant in (2e-3, 1e-3, 5e-4)
    ]
    swing = degrees_apart(motion.down, np.array([[0.0, 0.0, -1.0]])).max()
    assert swing > 30.0
    assert errors[1] < 0.65 * errors[0]
    assert errors[2] < 0.65 * errors[1]
    assert errors[2] < 0.005 * swing


@pytest.mark.parametrize("start", [(0.9, 0.2, 0.3), (0.2, 0.8, -0.5)])
def test_a_mesh_of_the_primary_rolls_alike_at_first(
    mujoco: ModuleType, rolling_primary: RollingBody, start: tuple[float, float, float]
) -> None:
    motion = roll(rolling_primary, start, duration_s=0.5, samples=11, tolerance=1e-8)
    errors = []
    for level in (4, 5, 6):
        directions, faces = geodesic_triangulation(level)
        points = 1e-3 * rolling_primary.body.position_mm(directions)
        mesh = f'<mesh name="body" vertex="{numbers(points)}" face="{numbers(faces)}"/>'
        down = down_in_mujoco(
            mujoco, rolling_primary, motion, 'type="mesh" mesh="body"', 2e-3, step_s=5e-4, mesh=mesh
        )
        errors.append(degrees_apart(down, motion.down)[-1])
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1.1
    assert degrees_apart(motion.down[-1:], motion.down[:1])[0] > 10.0
