#!/usr/bin/env bash
# patient_data.sh PALPATE SCRATCH DATA...: two lumbar MRI, one level of a spine as surfaces, T1 and T2 volumes.
# Exit 77: the first folder DATA that exists holds none of it.
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

# lumbar SUBJECT X0 Y0 X1 Y1 [mm]: region of the sagittal slices, x from the canal to behind the back, y one level.
lumbar() {
  cat > "$scratch/lumbar-$1.toml" <<TOML
title = "Lumbar MRI, subject $1"
[simulation]
duration = 1.9
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
[drive]
speed = 0.05
TOML
}
# Depth at which the line on which the needle lies first meets a role [mm].
first_of() {
  "$palpate" inspect "$1" | awk -v role="$2" '$5 == role { print $1; exit }'
}
event_depth() {  # of the first such event in a trace [mm]
  awk -F, -v event="$2" 'NR == 1 { for (n = 1; n <= NF; ++n) { if ($n == "tool.depth_m") d = n; if ($n == "tool.event") e = n } }
    $e == event { print 1000 * $d; exit }' "$1/trace.csv"
}

# Nominal depths from the data's README: 70 to 78 mm (177) and 42 to 52 mm (129) at mid-lumbar level. A node stands for
# 2.8 mm of depth and a skin found by `air` for half of one.
for subject in 177 129; do
  if [ "$subject" = 177 ]; then lumbar 177 136.3 131.6 240.2 188.0; else lumbar 129 157.9 112.8 240.2 169.2; fi
  depth[$subject]=$(first_of "$scratch/lumbar-$subject.toml" epidural-space)
  "$palpate" run "$scratch/lumbar-$subject.toml" --out "$scratch/$subject" --quiet
  lost[$subject]=$(event_depth "$scratch/$subject" loss-of-resistance)
  echo "subject $subject: canal at ${depth[$subject]} mm by the volume, resistance lost at ${lost[$subject]} mm"
done
between "${depth[177]}" 67.2 80.8 "depth of the canal, subject 177"
between "${depth[129]}" 39.2 54.8 "depth of the canal, subject 129"
between "$(echo "${depth[177]} - ${depth[129]}" | bc -l)" 15 36 "difference of the two patients"
