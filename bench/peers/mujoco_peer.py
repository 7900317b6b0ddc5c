"""MuJoCo with two inertias with play, as robot simulators model it: a second hinge whose soft limits are spring and damper."""

import time

import numpy as np

IMPEDANCE = 1e-4  # of the limits, the least that MuJoCo takes
MODEL = """<mujoco><compiler angle="radian"/><option timestep="{dt}" gravity="0 0 0"><flag contact="disable"/></option>
<worldbody><body><joint name="motor" type="hinge" axis="0 0 1" armature="{motor}" damping="{drag}"/>
<inertial pos="0 0 0" mass="1e-3" diaginertia="{small} {small} {small}"/>
<body><joint type="hinge" axis="0 0 1" range="{low} {high}" limited="true" solreflimit="{spring} {damper}"
solimplimit="{impedance} {impedance} 1e-6"/><inertial pos="0 0 0" mass="1" diaginertia="{load} {load} {load}"/></body>
</body></worldbody><actuator><motor joint="motor"/></actuator></mujoco>"""


def missing():
    """Return what to install, None if nothing."""
    try:
        import mujoco  # noqa: F401
    except ImportError:
        return "pip install mujoco"
    return None


def make_model(case, dt):
    """Return MuJoCo's model of a case of two inertias with play."""
    import mujoco

    (coupling,), rotors = case["couplings"], case["rotors"]
    small = 1e-6  # kg m^2, as a body must have some
    motor, load = rotors["motor"]["inertia"] - small, rotors["load"]["inertia"]
    # Negative solref (s_1, s_2): the acceleration of the joint is IMPEDANCE (s_1 r + s_2 dr/dt) over the limit's inverse mass.
    share = (1.0 - IMPEDANCE) * (1.0 / load + 1.0 / motor)
    half = 0.5 * coupling["play"]
    text = MODEL.format(
        dt=dt, motor=motor, load=load, small=small, low=-half, high=half, impedance=IMPEDANCE,
        drag=rotors["motor"]["load"]["drag"],
        spring=-share * coupling["torsional_stiffness"], damper=-share * coupling["torsional_damping"],
    )  # fmt: skip
    return mujoco.MjModel.from_xml_string(text)


def rollout(case, dt, control, threads, *, at_once):
    """Return wall and CPU time [s] of members under ``control``, shape [member, step], all steps in one call or one by one."""
    import mujoco
    from mujoco import rollout as mujoco_rollout

    model = make_model(case, dt)
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros((len(control), mujoco.mj_stateSize(model, kind)))
    datas = [mujoco.MjData(model) for _ in range(threads)]
    mujoco.mj_getState(model, datas[0], state[0], kind)
    state[:] = state[0]
    parts = (
        [control[:, :, None]]
        if at_once
        else [control[:, i : i + 1, None].copy() for i in range(control.shape[1])]
    )
    with mujoco_rollout.Rollout(nthread=threads) as pool:
        began, worked = time.perf_counter(), time.process_time()
        for part in parts:
            states, _ = pool.rollout([model] * len(control), datas, state, part)
            state = states[:, -1]
        return time.perf_counter() - began, time.process_time() - worked
