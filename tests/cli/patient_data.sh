#!/usr/bin/env bash
# patient_data.sh PALPATE SCRATCH DATA...: two lumbar MRI, one level of a spine as surfaces, T1 and T2 volumes.
# What inspect reads of each on the needle's line, and where needles through them lose resistance or are stopped. Exit 77: no folder DATA holds them.
set -euo pipefail
palpate=$1
scratch=$2
shift 2
data=
for folder in "$@"; do
  if [ -d "$folder/spider_lumbar_mri" ]; then data=$(cd "$folder" && pwd); break; fi
done
if [ -z "$data" ]; then echo "skip: no folder spider_lumbar_mri in $*"; exit 77; fi
rm -rf "$scratch"
mkdir -p "$scratch"

fail() { echo "FAIL: $*" >&2; exit 1; }
between() { awk -v v="$1" -v low="$2" -v high="$3" 'BEGIN { exit !(v >= low && v <= high) }' || fail "$4: $1 not in $2..$3"; }

# lumbar SUBJECT X0 Y0 X1 Y1 DEPTH [mm] DURATION [s]: region of the sagittal slices, x from the canal to behind the back,
# y one level; a needle goes so deep.
lumbar() {
  cat > "$scratch/lumbar-$1.toml" <<TOML
title = "Lumbar MRI, subject $1"
[simulation]
duration = $7
[tissue]
source = "mri"
[tissue.mri]
path = "$data/spider_lumbar_mri/subject_$1/images"
labels = "$data/spider_lumbar_mri/subject_$1/masks"
spacing = [4.7e-4, 4.7e-4, 9.0e-4]
materials = { 76 = "bone", 150 = "epidural-space" }
inward = "-x"
stride = 6
slice_stride = 3
air = 0.1
region = { min = [${2}e-3, ${3}e-3, 0.0], max = [${4}e-3, ${5}e-3, 0.02] }
[needle]
gauge = 16
[drive]
speed = 0.2
depth = ${6}e-3
from = -0.001
$soft
TOML
}
# A tip that rests on a few nodes must cut soft tissue by little force, or it drags it further than their distance.
soft='[[material]]
name = "subcutaneous-fat"
youngs_modulus = 24.0e3
density = 950.0
damping_ratio = 0.5
cutting_force = 0.05
friction = 2.0
[[material]]
name = "muscle"
youngs_modulus = 55.7e3
density = 1050.0
damping_ratio = 0.5
cutting_force = 0.1
friction = 5.0
[[material]]
name = "ligamentum-flavum"
youngs_modulus = 15.0e6
density = 1130.0
damping_ratio = 0.5
cutting_force = 2.0
friction = 50.0'
# Depth of the cut in the tissue one tick before a run's first event of a kind [mm]: the tip then sinks into softer tissue.
depth_of() { # folder event
  awk -F, -v event="$2" 'NR == 1 { for (n = 1; n <= NF; ++n) { if ($n == "tool.cut_m") { d = n } if ($n == "tool.event") { e = n } } next }
    index($e, event) { print 1000 * before; exit } { before = $d }' "$1/trace.csv"
}
# Depth at which the line on which the needle lies first meets a role [mm].
first_of() {
  "$palpate" inspect "$1" | awk -v role="$2" '$5 == role { print $1; exit }'
}
# Nominal depths from the data's README: 70 to 78 mm (177) and 42 to 52 mm (129) at mid-lumbar level. A node stands for
# 2.8 mm of depth and a skin found by `air` for half of one.
for subject in 177 129; do
  if [ "$subject" = 177 ]; then lumbar 177 136.3 131.6 240.2 188.0 72 0.37; else lumbar 129 157.9 112.8 240.2 169.2 48 0.25; fi
  depth[$subject]=$(first_of "$scratch/lumbar-$subject.toml" epidural-space)
  echo "subject $subject: canal ${depth[$subject]} mm below the skin by the volume"
  "$palpate" run "$scratch/lumbar-$subject.toml" --no-view --out "$scratch/run-$subject" >"$scratch/said" 2>&1 ||
    fail "subject $subject: $(cat "$scratch/said")"
  lost=$(depth_of "$scratch/run-$subject" loss-of-resistance)
  echo "subject $subject: resistance lost ${lost:-nowhere} mm deep"
  # In a step of 1 ms the needle goes 0.2 mm; two, for the tick that shows it.
  between "${lost:-0}" "$(awk -v d="${depth[$subject]}" 'BEGIN { print d - 0.4 }')" \
    "$(awk -v d="${depth[$subject]}" 'BEGIN { print d + 0.4 }')" "loss of resistance, subject $subject"
done
between "${depth[177]}" 67.2 80.8 "depth of the canal, subject 177"
between "${depth[129]}" 39.2 54.8 "depth of the canal, subject 129"
between "$(awk -v a="${depth[177]}" -v b="${depth[129]}" 'BEGIN { print a - b }')" 15 36 "difference of the two patients"

# Nodes of 2 mm; the surfaces are in metres, x to the front, z to the head.
surfaces="$data/vhm_lumbar_vertebrae"
cat > "$scratch/spine.toml" <<TOML
[simulation]
duration = 0.25
[tissue]
source = "mesh"
[tissue.mesh]
voxel = 0.002
inward = "+x"
origin = [-0.066, 0.0, 0.0705]
surround = { material = "muscle", min = [-0.014, -0.014, 0.0], max = [0.014, 0.014, 0.058] }
files = [
  { path = "$surfaces/L3.obj", material = "bone", priority = 2 },
  { path = "$surfaces/L4.obj", material = "bone", priority = 2 },
  { path = "$surfaces/L34_interspinous_constructed.obj", material = "interspinous-ligament" },
  { path = "$surfaces/L34_supraspinous_constructed.obj", material = "supraspinous-ligament" },
  { path = "$surfaces/L34_ligamentum_flavum_constructed.obj", material = "ligamentum-flavum" },
]
[needle]
gauge = 16
[drive]
speed = 0.2
depth = 0.046
from = -0.001
$soft
TOML
line=$("$palpate" inspect "$scratch/spine.toml" | awk '/from mm/ { on = 1; next } /^static/ { on = 0 } on { printf "%s ", $6 }')
echo "between the vertebrae: $line"
case "$line" in
  *supraspinous-ligament*interspinous-ligament*ligamentum-flavum*bone*) ;;
  *) fail "the needle between the vertebrae meets $line" ;;
esac
bone=$("$palpate" inspect "$scratch/spine.toml" --set 'needle.entry=[0.0, 0.012]' | awk '$1 == "bone_at_m" { print $2 }')
echo "mis-aimed by 12 mm: bone at $bone m"
between "$bone" 0.0 0.03 "depth of bone, mis-aimed"
"$palpate" run "$scratch/spine.toml" --no-view --out "$scratch/through" >"$scratch/said" 2>&1 || fail "$(cat "$scratch/said")"
passed=$(awk -F, '/puncture/ { for (n = 1; n <= NF; ++n) { if ($n ~ /ligament/) { printf "%s ", $n } } }' "$scratch/through/trace.csv")
echo "punctured between the vertebrae: $passed"
case "$passed" in
  *supraspinous-ligament*interspinous-ligament*ligamentum-flavum*) ;;
  *) fail "the needle between the vertebrae punctured $passed" ;;
esac
"$palpate" run "$scratch/spine.toml" --set 'needle.entry=[0.0, 0.012]' --set simulation.duration=0.1 --no-view --out "$scratch/stopped" \
  >"$scratch/said" 2>&1 || fail "$(cat "$scratch/said")"
stopped=$(depth_of "$scratch/stopped" bone)
echo "mis-aimed by 12 mm: stopped ${stopped:-nowhere} mm deep"
between "${stopped:-0}" "$(awk -v d="$bone" 'BEGIN { print 1000 * d - 0.4 }')" "$(awk -v d="$bone" 'BEGIN { print 1000 * d + 0.4 }')" \
  "where bone stopped the needle"
# L3 holds 80.6 and L4 72.6 cm3 by the data's README; a cell of 2 mm may be wrong within its half diagonal of the surface,
# and errors of so many cells cancel to a few per cent.
for body in L3:80.6 L4:72.6; do
  cm3=$("$palpate" inspect "$scratch/spine.toml" --json | tr -d ' \n' | sed "s/.*\"${body%%:*}.obj\":{\"material\":\"bone\",\"mesh_m3\":\([0-9.e-]*\),\"voxels_m3\":\([0-9.e-]*\).*/\2/")
  between "$(awk -v v="$cm3" -v t="${body#*:}" 'BEGIN { print 1e6 * v / t }')" 0.97 1.03 "voxels of ${body%%:*}"
done

for weighting in T1 T2; do
  file=$(echo "$weighting" | tr T t)w.nii.gz
  cat > "$scratch/$weighting.toml" <<TOML
[simulation]
duration = 0.01
[tissue]
source = "mri"
[tissue.mri]
path = "$data/sct_spine_mri_t1_t2/$file"
weighting = "$weighting"
inward = "anterior"
stride = 5
slice_stride = 4
TOML
  "$palpate" inspect "$scratch/$weighting.toml" > "$scratch/$weighting.txt" || fail "$file is refused"
  grep -q "weighting: $weighting" "$scratch/$weighting.txt" || fail "$file: no weighting"
  echo "$file: $(grep '^nodes' "$scratch/$weighting.txt")"
done
