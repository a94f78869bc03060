use super::*;

#[test]
fn whole_frames_of_adjacent_cycles_share_none() {
    let cycle = |start, end| DetectedCycle {
        start,
        end,
        regular: 1.0,
    };
    assert_eq!(whole_frames(&cycle(6.88, 39.68)), 7..40);
    assert_eq!(whole_frames(&cycle(39.68, 71.0)), 40..71);
    assert_eq!(whole_frames(&cycle(71.0, 80.0)), 71..80);
    assert_eq!(whole_frames(&cycle(0.0, 30.0)), 0..30);
}

#[test]
fn arrays_of_frames_are_measured_and_what_is_no_frame_left_out() {
    // Two frames of 3x2, the second empty, and one more pixel.
    let pixels = [0, 255, 255, 255, 200, 127, 0, 0, 0, 0, 0, 0, 255];
    let found: Vec<_> = lower_bodies(&pixels, [3, 2]).collect();
    // The lowest row has one pixel, in column 0; the mean column of the others is 2/3.
    let legs = LowerBody {
        spread: 0.0,
        sway: -2.0 / 9.0,
    };
    assert_eq!(found, [Some(legs), None]);
    assert_eq!(lower_bodies(&pixels, [0, 2]).count(), 0);
    assert_eq!(lower_bodies(&pixels, [3, 0]).count(), 0);
    assert_eq!(lower_bodies(&pixels, [usize::MAX, 2]).count(), 0);
}

#[test]
fn reasons_say_what_was_expected_and_found() {
    let text = |reason: NoCycle| reason.to_string();
    assert_eq!(
        text(NoCycle::TooShort { frames: 9 }),
        "expected a whole gait cycle, found 9 frames, which are too few (record two cycles or more)"
    );
    assert!(
        text(NoCycle::Standing { swing: 0.0012 })
            .ends_with("standing still: the legs swing by 0.1 % of the height")
    );
    let irregular = text(NoCycle::Irregular { regular: 0.18 });
    assert!(
        irregular.contains("expected 70 to 220 steady steps a minute"),
        "{irregular}"
    );
    assert!(
        irregular.contains("a steady wave explains 18 %"),
        "{irregular}"
    );
    let error = crate::Error::from(CycleFinder::new(200.0).expect_err("too fast"));
    assert_eq!(error.exit_code(), 2);
}
