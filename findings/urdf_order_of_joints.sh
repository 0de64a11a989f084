#!/usr/bin/env bash
# Guess: the numbers of a robot's pose stand in the order in which the joints are
# written in its URDF, in every reader.
# Instead: yourdfpy takes the file's order; MuJoCo goes down each branch (an elbow
# comes right after its own shoulder, wherever it is written); Pinocchio does so
# too, but goes through the branches by the alphabet.
# A user meets it with retargeted captures: the same row of numbers is three
# different poses of one robot, each of them plausible. Hand joints over by name.
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
    '<joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/><origin xyz="{}"/><axis xyz="0 0 1"/>'
    '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
)
text = "<robot name='two_arms'>" + "".join(map(link.format, ("base", "right_arm", "left_arm", "right_hand")))
text += joint.format("right_shoulder", "base", "right_arm", "0 -1 0")
text += joint.format("left_shoulder", "base", "left_arm", "0 1 0")
text += joint.format("right_elbow", "right_arm", "right_hand", "1 0 0") + "</robot>"
with open("robot.urdf", "w") as file:
    file.write(text)
row = np.array([0.1, 0.2, 0.3])

model = mujoco.MjModel.from_xml_path("robot.urdf")
data = mujoco.MjData(model)
data.qpos[:] = row
mujoco.mj_kinematics(model, data)
turn = np.arctan2(data.body("right_hand").xmat[3], data.body("right_hand").xmat[0])
orders = {"mujoco " + mujoco.__version__: ([model.joint(i).name for i in range(model.njnt)], turn)}

robot = yourdfpy.URDF.load("robot.urdf")
robot.update_cfg(row)
matrix = robot.get_transform("right_hand")
orders["yourdfpy 0.0.60"] = (list(robot.actuated_joint_names), np.arctan2(matrix[1, 0], matrix[0, 0]))

model = pinocchio.buildModelFromUrdf("robot.urdf")
data = model.createData()
pinocchio.framesForwardKinematics(model, data, row)
matrix = data.oMf[model.getFrameId("right_hand")].rotation
orders["pinocchio " + pinocchio.__version__] = (list(model.names)[1:], np.arctan2(matrix[1, 0], matrix[0, 0]))

expected = [
    (["right_shoulder", "right_elbow", "left_shoulder"], 0.3),
    (["right_shoulder", "left_shoulder", "right_elbow"], 0.4),
    (["left_shoulder", "right_shoulder", "right_elbow"], 0.5),
]
for (name, (order, turn)), (order_expected, turn_expected) in zip(orders.items(), expected, strict=True):
    print(name, order, f"the row 0.1 0.2 0.3 turns the right hand by {turn:.1f} rad")
    assert order == order_expected and abs(turn - turn_expected) < 1e-6, (order, turn)
END
venv/bin/python robot.py
