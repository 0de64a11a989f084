#!/usr/bin/env bash
# Guess: a joint that mimics another one (URDF) follows it in forward kinematics everywhere.
# What happens: yourdfpy follows; Pinocchio takes it for a free joint unless it is told
# (mimic=True); MuJoCo makes an equality of it that only its solver heeds, so that the kinematics
# of a pose do not follow. The same two angles put the tip at three places.
# Who meets it: hands and parallel links of robots, when poses are only looked at and not simulated.
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
  <joint name="right_knee" type="revolute"><mimic joint="right_hip" multiplier="2" offset="0.1"/><parent link="right"/><child link="hand"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="fixed" type="fixed"><parent link="hand"/><child link="tip"/><origin xyz="0.5 0 0"/></joint>
</robot>
XML
venv/bin/python - <<'PY'
import mujoco
import numpy as np
import pinocchio
import yourdfpy

robot = yourdfpy.URDF.load("robot.urdf", load_meshes=False, build_scene_graph=True)
robot.update_cfg({"right_hip": 0.3, "left_hip": 0.0})
follows = robot.get_transform("hand")[:3, :3]
model = mujoco.MjModel.from_xml_path("robot.urdf")
data = mujoco.MjData(model)
data.qpos[model.joint("right_hip").qposadr[0]] = 0.3
mujoco.mj_kinematics(model, data)
stays = data.xmat[model.body("hand").id].reshape(3, 3)


def angle(matrix):
    return round(float(np.arctan2(matrix[1, 0], matrix[0, 0])), 3)


sizes = [pinocchio.buildModelFromUrdf("robot.urdf").nq,
         pinocchio.buildModelFromUrdf("robot.urdf", mimic=True).nq]
print("mujoco", mujoco.__version__, "pinocchio", pinocchio.__version__, "yourdfpy 0.0.60:",
      "angle of the link after the mimicking joint: yourdfpy", angle(follows), "mujoco",
      angle(stays), "equalities", model.neq, "| pinocchio's coordinates without and with mimic",
      sizes)
assert (angle(follows), angle(stays), model.neq, sizes) == (1.0, 0.3, 1, [3, 2]), "changed"
PY
