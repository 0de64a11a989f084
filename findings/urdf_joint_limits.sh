#!/usr/bin/env bash
# Guess: forward kinematics of a robot puts a joint at the angle it is given, also
# beyond the limits of its URDF, or refuses that angle; limits bind only whoever
# solves or simulates.
# Instead: pytransform3d moves the joint to its limit and says nothing, so a pose
# of 1.5 rad is drawn at 1.0. yourdfpy, Pinocchio, MuJoCo and ikpy place it at 1.5.
# A user whose retargeted motion leaves the limits here and there sees hands and
# feet that stop short in one viewer, and errors measured there are too small.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check \
  pytransform3d==3.17.0 yourdfpy==0.0.60 pin==4.1.0 mujoco==4.0.0 ikpy==4.2.1
cat >robot.py <<'END'
import warnings

import ikpy.chain
import mujoco
import numpy as np
import pinocchio
import pytransform3d
import yourdfpy
from pytransform3d.urdf import UrdfTransformManager

ASKED, LIMIT = 1.5, 1.0
link = (
    '<link name="{}"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
text = (
    "<robot name='arm'>" + link.format("base") + link.format("arm")
    + '<joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>'
    + f'<limit lower="{-LIMIT}" upper="{LIMIT}" effort="1" velocity="1"/></joint></robot>'
)
with open("robot.urdf", "w") as file:
    file.write(text)


def angle(matrix):
    return round(float(np.arctan2(matrix[1, 0], matrix[0, 0])), 3)


seen = {}
manager = UrdfTransformManager()
manager.load_urdf(text)
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    manager.set_joint("elbow", ASKED)
assert not said, said
seen["pytransform3d " + pytransform3d.__version__] = angle(manager.get_transform("arm", "base"))

robot = yourdfpy.URDF.load("robot.urdf")
robot.update_cfg({"elbow": ASKED})
seen["yourdfpy 0.0.60"] = angle(robot.get_transform("arm"))

model = pinocchio.buildModelFromUrdf("robot.urdf")
data = model.createData()
pinocchio.framesForwardKinematics(model, data, np.array([ASKED]))
seen["pinocchio " + pinocchio.__version__] = angle(data.oMf[model.getFrameId("arm")].rotation)

model = mujoco.MjModel.from_xml_path("robot.urdf")
data = mujoco.MjData(model)
data.joint("elbow").qpos[:] = ASKED
mujoco.mj_kinematics(model, data)
seen["mujoco " + mujoco.__version__] = angle(data.body("arm").xmat.reshape(3, 3))

chain = ikpy.chain.Chain.from_urdf_file("robot.urdf", base_elements=["base"], active_links_mask=[False, True])
seen["ikpy 4.2.1"] = angle(chain.forward_kinematics([0.0, ASKED]))

print(f"elbow asked for at {ASKED} rad, limit {LIMIT} rad")
for name, found in seen.items():
    print(name, "places it at", found)
assert list(seen.values()) == [LIMIT, ASKED, ASKED, ASKED, ASKED], seen
END
venv/bin/python robot.py
