#!/usr/bin/env bash
# Guess: the joints of a URDF have one order in every reader, that of the file, so that a row of
# joint angles can be passed from one to another.
# What happens: three readers, three orders: yourdfpy has the order of the file, MuJoCo goes down
# each limb first, and Pinocchio sorts joints of one parent by name.
# Who meets it: a motion as CSV or npz of joint angles without names moves other joints.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check mujoco==4.0.0 pin==4.1.0 yourdfpy==0.0.60 2>/dev/null
cat >robot.urdf <<"XML"
<robot name="r">
  <link name="base"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="right"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="left"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tip"/>
  <joint name="right_hip" type="revolute"><parent link="base"/><child link="right"/><origin xyz="0 1 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="left_hip" type="revolute"><parent link="base"/><child link="left"/><origin xyz="0 -1 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="right_knee" type="revolute"><parent link="right"/><child link="hand"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="fixed" type="fixed"><parent link="hand"/><child link="tip"/><origin xyz="0.5 0 0"/></joint>
</robot>
XML
venv/bin/python - <<'PY'
import mujoco
import pinocchio
import yourdfpy

model = mujoco.MjModel.from_xml_path("robot.urdf")
orders = {
    "mujoco": [model.joint(number).name for number in range(model.njnt)],
    "pinocchio": list(pinocchio.buildModelFromUrdf("robot.urdf").names)[1:],
    "yourdfpy": list(yourdfpy.URDF.load("robot.urdf", load_meshes=False).actuated_joint_names),
}
print("mujoco", mujoco.__version__, "pinocchio", pinocchio.__version__, "yourdfpy 0.0.60", orders)
assert orders == {
    "mujoco": ["right_hip", "right_knee", "left_hip"],
    "pinocchio": ["left_hip", "right_hip", "right_knee"],
    "yourdfpy": ["right_hip", "left_hip", "right_knee"],
}, "the behaviour has changed"
PY
