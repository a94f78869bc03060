//! The outcome for each file of the folder `hard`: as its README requires, or our choice where it
//! leaves one.

/// The outcome of importing a file.
#[derive(Clone, Copy, Debug)]
pub enum End {
    /// Exit code 1 and one line that contains this text; nothing is written.
    Refused(&'static str),
    /// A pack, and a warning that contains this text.
    Warned(&'static str),
    /// A pack, and no warnings other than those of a short clip without faults.
    Accepted,
    /// The joints have the places of 00_reference_ok.bvh, within 1e-3 of the file's unit.
    SameMotion,
    /// The angles on the canonical skeleton are those of this file within 1e-3, the offsets within
    /// 1e-3 mm.
    SameTake(&'static str, Option<&'static str>),
    /// The farthest move of a joint in a frame, metres.
    Smooth(f64),
}

use End::{Accepted, Refused, SameMotion, SameTake, Smooth, Warned};

/// Warnings about a short clip, or a format that states no rate.
pub const USUAL: [&str; 3] = [
    "of a stride is recorded: the rest is interpolated",
    "phase 0 moved to the left contact",
    "an AMC states no frame rate",
];

pub const REFERENCE: &str = "00_reference_ok.bvh";
const SAME_TAKE: End = SameTake(REFERENCE, None);

/// A file, the skeleton of an AMC, and the outcomes.
pub type Case = (&'static str, Option<&'static str>, &'static [End]);

#[rustfmt::skip]
pub const SKELETONS: &[Case] = &[
    (REFERENCE, None, &[Accepted]),
    // There is no lenient mode: a truncated file is an error.
    ("01_truncated_motion.bvh", None, &[Refused(":172: frame 52: expected 60 values in the row, found 11")]),
    // Our choice: with fewer rows than stated the file is truncated, with more the count is wrong.
    ("02_frames_declared_too_many.bvh", None, &[Refused(":180: expected 500 frames, found 60")]),
    ("03_frames_declared_too_few.bvh", None, &[Warned("20 frames declared, 60 present: all are used"), SameMotion]),
    ("04_nan_inf_values.bvh", None, &[Refused(":130: frame 10, Yrotation of RightUpLeg")]),
    ("05_zero_length_bones.bvh", None, &[Warned("LeftShank lies on its parent joint")]),
    ("06_rotation_order_YXZ.bvh", None, &[Accepted, SameMotion]),
    ("07_rotation_order_mixed_per_joint.bvh", None, &[Accepted, SameMotion]),
    ("08_heading_crosses_180.bvh", None, &[Accepted, Smooth(0.05)]),
    ("09_gimbal_lock_crossing.bvh", None, &[Accepted, Smooth(0.04)]),
    ("10_crlf.bvh", None, &[Accepted, SameMotion]),
    ("11_tabs.bvh", None, &[Accepted, SameMotion]),
    ("12_exponent_notation.bvh", None, &[Accepted, SameMotion]),
    ("13_no_end_sites.bvh", None, &[Accepted, SAME_TAKE]),
    ("14_huge_coordinates_1e6.bvh", None, &[Accepted, SAME_TAKE]),
    ("15_frame_time_zero.bvh", None, &[Refused(":119: expected a frame time of 0.0001 to 1 seconds, found `0`")]),
    ("15b_frame_time_negative.bvh", None, &[Refused(":119: expected a frame time")]),
    ("15c_frame_time_nan.bvh", None, &[Refused(":119: expected a frame time")]),
    // It is read (up to 4,096 joints), but the chain has no legs.
    ("16_deep_hierarchy_500.bvh", None, &[Refused("no leg joints")]),
    ("17_duplicate_joint_names.bvh", None, &[Refused("no right thigh joint (several joints share a name (`LeftUpLeg`")]),
    ("18_empty.bvh", None, &[Refused("the file is empty")]),
    ("19_line_100MB.bvh.xz", None, &[Refused(":120: the line is longer than 1048576 bytes")]),
    // It is read, but the name Hüfte for thighs is unknown.
    ("20_non_utf8_names_latin1.bvh", None, &[Refused("no leg joints"), SameMotion]),
    ("20b_shift_jis_names.bvh", None, &[Refused("no leg joints"), SameMotion]),
    ("21_cr_only_line_endings.bvh", None, &[Accepted, SameMotion]),
    ("22_utf8_bom.bvh", None, &[Accepted, SameMotion]),
    ("23_utf16.bvh", None, &[Refused(":1: the text is UTF-16; save it as UTF-8")]),
    ("24_no_motion_section.bvh", None, &[Refused("expected MOTION, found the end of the file")]),
    ("25_lowercase_keywords.bvh", None, &[Accepted, SameMotion]),
    ("26_positions_on_all_joints.bvh", None, &[Accepted, SameMotion]),
    ("27_rotation_channels_before_position.bvh", None, &[Accepted, SameMotion]),
    ("28_spaces_and_namespace_in_names.bvh", None, &[Accepted, SameMotion, SAME_TAKE]),
    ("29_missing_closing_brace.bvh", None, &[Refused(":116: MOTION inside of 1 open braces")]),
    ("30_two_roots.bvh", None, &[Refused(":117: a second ROOT")]),
    ("31_one_frame.bvh", None, &[Refused("no gait cycle")]),
    ("32_zero_frames.bvh", None, &[Refused("the motion has no frames")]),
    ("33_frame_count_4e9.bvh", None, &[Refused(":125: expected 4000000000 frames, found 5")]),
    ("34_frame_count_negative.bvh", None, &[Refused(":118: expected a count of frames, found `-5`")]),
    ("35_channels_count_mismatch.bvh", None, &[Refused(":9: expected 3 channel names, found 2")]),
    ("36_decimal_comma.bvh", None, &[Refused("decimal commas are not numbers")]),
    ("37_metres.bvh", None, &[Accepted, SAME_TAKE]),
    // Our choice: a row is a line.
    ("38_frames_wrapped_over_lines.bvh", None, &[Refused(":120: frame 0: expected 60 values in the row, found 30")]),
    ("39_overflow_1e400.bvh", None, &[Refused(":127: frame 7, Xposition of Hips: expected a finite number")]),
    ("40_extra_column.bvh", None, &[Refused(":120: frame 0: expected 60 values in the row, found 61")]),
    ("41_short_row_in_middle.bvh", None, &[Refused(":150: frame 30: expected 60 values")]),
    ("42_non_numeric_token.bvh", None, &[Refused(":150: frame 30, Xposition of Hips: expected a number, found `abc`")]),
    // Our choice: cut at the jump, which leaves half a stride.
    ("43_root_teleport_frame.bvh", None, &[Refused("no gait cycle: no foot contacts are recorded; expected two steps or more of a walk or a run (the root jumps 3.00 m at frame 30")]),
    ("44_tpose_first_frame.bvh", None, &[Warned("frame 0 is a T-pose and was dropped"), SAME_TAKE]),
    ("45_standing_still_no_gait.bvh", None, &[Refused("no gait cycle: no foot contacts")]),
    ("46_binary_garbage.bvh", None, &[Refused(":1: expected HIERARCHY")]),
    ("47_nul_bytes.bvh", None, &[Refused(":58: a NUL byte")]),
    ("48_unknown_channel.bvh", None, &[Refused(":9: unknown channel `Wscale`")]),
    ("49_fps_halved_walks_double_speed.bvh", None, &[Warned("implausible: is the frame rate of 120.0 Hz right?")]),
    ("50_left_right_swapped_names.bvh", None, &[Warned("legs were named the wrong way round: exchanged"), SAME_TAKE]),
    ("51_no_legs.bvh", None, &[Refused("no leg joints")]),
    ("52_orientation_z_up.bvh", None, &[Accepted, SAME_TAKE]),
    // Four bones; the rest of the figure is an average adult's.
    ("60_ok.amc", Some("60_ok.asf"), &[Warned("the skeleton has no feet, arms, forearms, hands, head")]),
    ("60_ok.amc", Some("61_asf_no_units.asf"), &[Warned("the ASF states no unit of length"), SameTake("60_ok.amc", Some("60_ok.asf"))]),
    ("62_amc_radians.amc", Some("62_asf_radians.asf"), &[Warned("bones' axes are turned by up to 20: taken as degrees"), SameTake("60_ok.amc", Some("60_ok.asf"))]),
    ("63_amc_frame_numbers_skip.amc", Some("60_ok.asf"), &[Refused(":298: expected frame 50, found 53")]),
    ("64_amc_bone_missing_in_one_frame.amc", Some("60_ok.asf"), &[Refused(":358: frame 60 lacks the bone `ltibia`")]),
    ("65_amc_bone_not_in_asf.amc", Some("60_ok.asf"), &[Refused(":9: no bone `tail` in the ASF")]),
    ("66_amc_no_degrees_keyword.amc", Some("60_ok.asf"), &[Warned("the AMC states no unit of angle"), SameTake("60_ok.amc", Some("60_ok.asf"))]),
    ("60_ok.amc", Some("67_asf_hierarchy_cycle.asf"), &[Refused(":50: `rfemur` has a second parent (a cycle?)")]),
    ("68_amc_truncated.amc", Some("60_ok.asf"), &[Refused(":718: frame 120 lacks the bone `rfemur`")]),
    ("60_ok.amc", Some("69_asf_direction_zero.asf"), &[Refused(":16: the bone's direction is zero")]),
    ("70_amc_duplicate_frame_number.amc", Some("60_ok.asf"), &[Refused(":238: expected frame 40, found 39")]),
    // Two joints and one leg; another test checks that it is read.
    ("real/bvh_rotation_first_root.bvh", None, &[Refused("no leg joints")]),
    ("real/cmu_03_02_root_glitch.amc", Some("real/cmu_03_02_root_glitch.asf"), &[Warned("only frames 50 to 364 of 365 are used")]),
    ("real/cmu_09_10_root_teleport.amc", Some("real/cmu_09_10_root_teleport.asf"), &[Warned("the root jumps 1.92 m at frame 4")]),
];

/// A file, its markers, frames, rate in Hz and missing positions, parts of the reader's warnings,
/// and the outcome.
pub type Recorded = (
    &'static str,
    usize,
    usize,
    f64,
    usize,
    &'static [&'static str],
    End,
);

/// 0.25 s without an ankle is too long to be filled, so the longer side is used, half a stride.
const LONG_GAP: &str = "no gait cycle: no foot contacts are recorded; expected two steps or more of a walk or a run (markers are missing: only frames 55 to 119";

#[rustfmt::skip]
pub const MARKERS: &[Recorded] = &[
    ("80_trc_ok.trc", 7, 120, 100.0, 0, &[], Warned("no markers of the trunk and the head")),
    ("81_trc_blank_gap.trc", 7, 120, 100.0, 25, &[], Refused(LONG_GAP)),
    ("82_trc_nan_gap.trc", 7, 120, 100.0, 25, &[], Refused(LONG_GAP)),
    ("83_trc_zero_gap.trc", 7, 120, 100.0, 25, &[], Refused(LONG_GAP)),
    ("84_trc_9999999_gap.trc", 7, 120, 100.0, 25, &[], Refused(LONG_GAP)),
    // Our choice: rows and names count, not the header.
    ("85_trc_numframes_wrong.trc", 7, 120, 100.0, 0, &["`900` frames stated, 120 present"], Warned("`900` frames stated")),
    ("86_trc_nummarkers_wrong.trc", 7, 120, 100.0, 0, &["`9` markers stated, 7 present"], Warned("`9` markers stated")),
    // The unit is checked with the legs, after reading.
    ("87_trc_units_m_values_mm.trc", 7, 120, 100.0, 0, &[], Warned("the stated unit makes the legs 818")),
    ("88_trc_rate_vs_time_conflict.trc", 7, 120, 100.0, 0, &["the time column is used"], Warned("the time column is used")),
    // Our choice: accepted, as spaces are unambiguous without blank values.
    ("89_trc_space_separated.trc", 7, 120, 100.0, 0, &[], Warned("no markers of the trunk and the head")),
    ("90_trc_left_right_swap_midway.trc", 7, 120, 100.0, 0, &[], Warned("change places at frame 60")),
    ("91_trc_jitter_spike.trc", 7, 120, 100.0, 0, &[], Warned("marker RANK jumps at frame 70")),
    ("real/trc_crlf.trc", 41, 10, 60.0, 0, &[], Refused("no gait cycle")),
    ("real/trc_dataWithBlanksForMissingMarkers.trc", 40, 464, 250.0, 15_005, &[], Refused("no gait cycle")),
    ("real/trc_dataWithEformat.trc", 14, 5, 119.88012, 0, &[], Refused("no marker for the left")),
    ("real/trc_dataWithNaNsOfDifferentCases.trc", 14, 5, 250.0, 5, &[], Refused("no marker for the left")),
    ("real/trc_exampleFormat.trc", 3, 5, 100.0, 2, &[], Refused("no marker has a known name")),
    ("real/trc_header_900_frames_has_73.trc", 41, 73, 60.0, 0, &["`900` frames stated, 73 present"], Warned("`900` frames stated")),
    // From 0 to 1.220 s in 183 steps: 150 Hz, with times rounded to a millisecond.
    ("real/trc_rate150_time_142.86_half_missing.trc", 55, 184, 150.0, 4_968, &["`28` markers stated, 55 present", "1 markers share their name"], Warned("`28` markers stated")),
    ("real/c3d_enc_Eb015pi.c3d", 26, 450, 50.0, 226, &[], Refused("no marker for the left")),
    ("real/c3d_enc_Eb015pr.c3d", 26, 450, 50.0, 226, &[], Refused("no marker for the left")),
    ("real/c3d_enc_Eb015vi.c3d", 26, 450, 50.0, 226, &[], Refused("no marker for the left")),
    ("real/c3d_enc_Eb015vr.c3d", 26, 450, 50.0, 226, &[], Refused("no marker for the left")),
    ("real/c3d_enc_Eb015si.c3d", 26, 450, 50.0, 226, &[], Refused("no marker for the left")),
    ("real/c3d_enc_Eb015sr.c3d", 26, 450, 50.0, 226, &[], Refused("no marker for the left")),
    ("real/c3d_enc2_pc_int.c3d", 36, 89, 50.0, 228, &[], Refused("no marker for the left")),
    ("real/c3d_enc2_pc_real.c3d", 36, 89, 50.0, 228, &[], Refused("no marker for the left")),
    ("real/c3d_enc2_dec_int.c3d", 36, 89, 50.0, 228, &[], Refused("no marker for the left")),
    ("real/c3d_enc2_dec_real.c3d", 36, 89, 50.0, 228, &[], Refused("no marker for the left")),
    ("real/c3d_enc2_sgi_int.c3d", 36, 89, 50.0, 228, &["points out of the parameter section"], Refused("no marker for the left")),
    ("real/c3d_enc2_sgi_real.c3d", 36, 89, 50.0, 228, &["points out of the parameter section"], Refused("no marker for the left")),
    ("real/c3d_mycube.c3d", 14, 1, 50.0, 0, &[], Refused("no marker has a known name")),
    ("real/c3d_FP_Type3.c3d", 34, 2, 250.0, 0, &[], Refused("is seen in 2 of 2 frames")),
];

#[rustfmt::skip]
pub const NO_MARKERS: &[(&str, &str)] = &[
    ("c3d_empty.c3d", "the file is empty"),
    ("c3d_truncated_Eb015pr.c3d", "at byte 60000: the file ends after 81 of 450 frames"),
    ("real/c3d_bad_parameter_section.c3d", "at byte 5771: expected a parameter, found a name that is not ASCII"),
    ("real/c3d_bad_parameter_offset.c3d", "at byte 1290: parameter UNITS: its 128 bytes of data do not fit"),
    ("real/c3d_parameter_overflow.c3d", "at byte 23469: parameter DESCRIPTIONS: its 1536 bytes of data do not fit"),
    ("real/trc_truncated.trc", ":3: expected the header's values, found the end of the file"),
];
