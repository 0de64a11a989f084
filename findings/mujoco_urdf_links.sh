#!/usr/bin/env bash
# Guess: every link of a URDF is a body in MuJoCo.
# What happens: the root link becomes the world, and a link on a fixed joint is merged into its
# parent: both names are gone, and there is no frame to ask for.
# Who meets it: feet, hands and sensors are mostly links on fixed joints, and motions are given as
# places of bodies.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check mujoco==4.0.0 yourdfpy==0.0.60 2>/dev/null
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
import yourdfpy

model = mujoco.MjModel.from_xml_path("robot.urdf")
bodies = [model.body(number).name for number in range(model.nbody)]
links = list(yourdfpy.URDF.load("robot.urdf", load_meshes=False).link_map)
print("mujoco", mujoco.__version__, bodies, "yourdfpy 0.0.60", links)
assert bodies == ["world", "right", "hand", "left"], "the behaviour has changed"
assert set(links) == {"base", "right", "left", "hand", "tip"}
PY
