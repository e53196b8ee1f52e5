#!/bin/bash
# Calibrates a camera of the benchmark with COMPOTE: calibrate.sh BIN CONFIGURATION OUT [NOISE_PX]
#
# BIN: the folder of the programs that Makefile built. CONFIGURATION: a folder such as benchmark/r12-a-thin. White images are those of the
# sensor with noise if NOISE_PX is given, which is also the standard deviation of what is added to the true corners and blur radii:
# COMPOTE's own detection asks a person to click on every board. Writes OUT/intrinsics.js for `holo eval-calibration`.
set -eu
bin=$(realpath "$1") configuration=$(realpath "$2") noise=${4:-0}
mkdir -p "$3"
cd "$3"
images=boards_images.js
[ "$noise" = 0 ] || images=boards_images_noisy.js
sed "s#\"\.\./#\"$configuration/#" "$configuration/compote/$images" > images.js
python3 - "$configuration/compote/boards_true_features.js" "$noise" > features.js << 'PYTHON'
import json, random, sys
data, sigma, normal = json.load(open(sys.argv[1])), float(sys.argv[2]), random.Random(1)
for feature in data["features"]:
    for key in ("u", "v", "rho"):
        feature[key] += normal.gauss(0, sigma)
json.dump(data, sys.stdout)
PYTHON
# Both programs ask whether to go on and to save, and keep their window open after the end.
run() {
    log=$1
    shift
    yes y | head -n 2000 > answers
    xvfb-run -a "$@" -g false -l 7 < answers > "$log" 2>&1 &
    for second in $(seq 1200); do
        sleep 1
        grep -q EOF "$log" && break
        kill -0 $! 2> /dev/null || break
    done
    sleep 1
    pkill -f "$1" || true
    wait || true
}
rm -f camera-*.js
run precalibrate.log "$bin/precalibrate" -i images.js -c "$configuration/compote/camera.js" -p params.js
mv camera-*.js before.js
run calibrate.log "$bin/calibrate" -c before.js -p params.js -s "$configuration/compote/scene.js" -f features.js \
    -o intrinsics.js -e extrinsics.js
ls intrinsics.js
