#!/usr/bin/env bash
# Guess: a joint that mimics another (2 x + 0.1) follows it in the forward
# kinematics of every reader that knows the element.
# Instead: yourdfpy follows it, with its own number gone from the pose. MuJoCo
# keeps a number for it and does not move it in the kinematics: the coupling is an
# equality that only the simulation pulls at. Pinocchio ignores it by default and
# takes its number; with mimic=True it follows.
# A user who shows a captured hand by kinematics sees fingers that follow in one
# program and stay straight in the next; rows also differ in length.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check mujoco==4.0.0 yourdfpy==0.0.60 pin==4.1.0
cat >robot.py <<'END'
import mujoco
import numpy as np
import pinocchio
import yourdfpy

link = '<link name="{}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
joint = (
    '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>'
    '<limit lower="-3" upper="3" effort="1" velocity="1"/>{3}</joint>'
)
text = "<robot name='finger'>" + "".join(map(link.format, ("palm", "near", "far")))
text += joint.format("knuckle", "palm", "near", "")
text += joint.format("tip", "near", "far", '<mimic joint="knuckle" multiplier="2" offset="0.1"/>') + "</robot>"
with open("robot.urdf", "w") as file:
    file.write(text)
seen = {}

model = mujoco.MjModel.from_xml_path("robot.urdf")
data = mujoco.MjData(model)
data.joint("knuckle").qpos[:] = 0.2
mujoco.mj_kinematics(model, data)
matrix = data.body("far").xmat.reshape(3, 3)
seen["mujoco " + mujoco.__version__] = (model.nq, round(float(np.arctan2(matrix[1, 0], matrix[0, 0])), 3))

robot = yourdfpy.URDF.load("robot.urdf")
robot.update_cfg({"knuckle": 0.2})
matrix = robot.get_transform("far")
seen["yourdfpy 0.0.60"] = (robot.num_dofs, round(float(np.arctan2(matrix[1, 0], matrix[0, 0])), 3))

for mimic in (False, True):
    model = pinocchio.buildModelFromUrdf("robot.urdf", mimic=True) if mimic else pinocchio.buildModelFromUrdf("robot.urdf")
    data = model.createData()
    row = np.zeros(model.nq)
    row[0] = 0.2
    pinocchio.framesForwardKinematics(model, data, row)
    matrix = data.oMf[model.getFrameId("far")].rotation
    name = f"pinocchio {pinocchio.__version__}" + (", mimic=True" if mimic else "")
    seen[name] = (model.nq, round(float(np.arctan2(matrix[1, 0], matrix[0, 0])), 3))

print("knuckle at 0.2 rad; if the tip follows, it points to 0.2 + 2 x 0.2 + 0.1 = 0.7 rad")
for (name, answer), expected in zip(seen.items(), ((2, 0.2), (1, 0.7), (2, 0.2), (1, 0.7)), strict=True):
    print(name, "numbers of a pose:", answer[0], "tip points to", answer[1])
    assert answer == expected, answer
END
venv/bin/python robot.py
