#!/usr/bin/env bash
# Scores and times recognizers and checks the results against limits. The action of this folder runs
# it. Its parameters are environment variables, one for each of the action's inputs. It also works
# outside CI:
#
#     MODELS=mine.onnx BENCH_LIMITS=limits.toml bash gate.sh
#
# Exits with 4 if a limit is missed, with 3 if one is undecided and CANNOT_TELL is "fail", else with
# 0; with 1 or 2 after an error.
set -euo pipefail

refuse() {
    echo "error: $*" >&2
    exit 2
}

# `words NAME TEXT`: sets the array NAME to TEXT's words or, if it has several lines, to its lines.
words() {
    local -n into=$1
    if [[ $2 == *$'\n'* ]]; then
        mapfile -t into < <(grep -v '^[[:space:]]*$' <<< "$2" || true)
    else
        read -ra into <<< "$2"
    fi
}

edgegait=${EDGEGAIT:-edgegait}
out=${OUT:-edgegait-gate}
runs=${RUNS:-3}
tries=${TRIES:-2}
baseline=${BASELINE:-}
words models "${MODELS:-}"
words data "${DATA:-}"
words score_arguments "${SCORE_ARGUMENTS:-}"
words bench_arguments "${BENCH_ARGUMENTS---no-accuracy}"

((${#models[@]} > 0)) || refuse "MODELS: expected models, found none"
[[ $runs =~ ^[1-9][0-9]*$ ]] || refuse "RUNS: expected a number of 1 or more, found $runs"
[[ $tries =~ ^[1-9][0-9]*$ ]] || refuse "TRIES: expected a number of 1 or more, found $tries"
case ${CANNOT_TELL:-warn} in
    warn | fail) ;;
    *) refuse "CANNOT_TELL: expected warn or fail, found $CANNOT_TELL" ;;
esac
[[ -n ${SCORE_LIMITS:-}${BENCH_LIMITS:-} ]] || refuse "expected SCORE_LIMITS, BENCH_LIMITS or both, found neither"
for limits in "${SCORE_LIMITS:-}" "${BENCH_LIMITS:-}"; do
    [[ -z $limits || -r $limits ]] || refuse "$limits: expected a file of limits, found none"
done
if [[ -n $baseline && ! -d $baseline ]]; then
    echo "::warning::EdgeGait gate: there is no folder $baseline: limits relative to a baseline are left out"
    baseline=
fi
if [[ -n $baseline && -d $out && $(realpath "$baseline") == $(realpath "$out") ]]; then
    refuse "BASELINE and OUT: expected two folders, found $out twice (results would be compared with themselves)"
fi

mkdir -p "$out"
# Remove the results of an earlier run.
rm -f "$out"/comment.md "$out"/score.json "$out"/bench-*.json
: > "$out/comment.md"
worst=0

# `judge NAME LIMITS ARGUMENT...`: sets `status`; other than 0, 3 and 4 end the script.
judge() {
    local name=$1
    shift
    status=0
    "$edgegait" gate "$@" --markdown "$out/$name.md" --junit "$out/$name.xml" --bencher "$out/$name.bencher.json" \
        --json "$out/$name.gate.json" --overwrite || status=$?
    case $status in
        0 | 3 | 4) ;;
        *) exit "$status" ;;
    esac
}

# `add NAME`: adds the judgement to the comment and the outcome; 4 outweighs 3.
add() {
    cat "$out/$1.md" >> "$out/comment.md"
    echo >> "$out/comment.md"
    ((status <= worst)) || worst=$status
}

# `of_baseline NAME`: prints the gate's arguments for the baseline's files, or for no baseline.
of_baseline() {
    local files=()
    [[ -z $baseline ]] || mapfile -t files < <(ls "$baseline/$1".json "$baseline/$1"-*.json 2> /dev/null)
    if ((${#files[@]} == 0)); then
        echo --without-baseline
        return
    fi
    printf '%s\n' "${files[0]}"
    for file in "${files[@]:1}"; do
        printf '%s\n' --baseline-run "$file"
    done
}

if [[ -n ${SCORE_LIMITS:-} ]]; then
    "$edgegait" score "${models[@]}" "${data[@]}" "${score_arguments[@]}" --out "$out/report" --json "$out/score.json" --overwrite
    mapfile -t before < <(of_baseline score)
    judge score "$SCORE_LIMITS" "$out/score.json" "${before[@]}"
    add score
fi

if [[ -n ${BENCH_LIMITS:-} ]]; then
    mapfile -t before < <(of_baseline bench)
    for ((try = 1; try <= tries; try++)); do
        more=()
        for ((run = 1; run <= runs; run++)); do
            "$edgegait" bench "${models[@]}" "${bench_arguments[@]}" --json "$out/bench-$run.json" --overwrite
            ((run == 1)) || more+=(--run "$out/bench-$run.json")
        done
        judge bench "$BENCH_LIMITS" "$out/bench-1.json" "${before[@]}" "${more[@]}"
        ((status == 3)) || break
    done
    add bench
fi

case $worst in
    0) outcome=holds ;;
    3) outcome="cannot tell" ;;
    *) outcome=missed ;;
esac
if [[ -n ${GITHUB_STEP_SUMMARY:-} ]]; then cat "$out/comment.md" >> "$GITHUB_STEP_SUMMARY"; fi
if [[ -n ${GITHUB_OUTPUT:-} ]]; then echo "outcome=$outcome" >> "$GITHUB_OUTPUT"; fi
if ((worst == 3)) && [[ ${CANNOT_TELL:-warn} == warn ]]; then
    echo "::warning::EdgeGait gate: a limit is undecided"
    exit 0
fi
exit "$worst"
