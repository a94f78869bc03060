use super::*;
use crate::budget::MAX_TEMPLATE_BYTES;
use crate::silhouette::Silhouette;

/// The four frames [[1,0],[0,1]], [[1,1],[0,0]], [[1,0],[0,1]], [[1,1],[0,1]]; bit 0 is the
/// left column.
const FOUR: [[u64; 2]; 4] = [[0b01, 0b10], [0b11, 0b00], [0b01, 0b10], [0b11, 0b10]];

/// Returns the upper left two by two pixels of each plane of a template of these frames.
fn corners(mut builder: TemplateBuilder, frames: &[[u64; 2]]) -> heapless::Vec<[u8; 4], 3> {
    let size = builder.size;
    for rows in frames {
        let frame = AnySilhouette::Binary(Silhouette::from_rows(size, rows));
        builder.add(&frame).expect("room");
    }
    let mut bytes = [7; MAX_TEMPLATE_BYTES];
    builder.finish(&mut bytes);
    let length = builder.kind().bytes(size);
    assert!(bytes[length..].iter().all(|&byte| byte == 7));
    let planes = bytes[..length].chunks(size.pixels());
    planes
        .map(|plane| {
            let at = |row: usize, column: usize| plane[row * size.columns() + column];
            // These pixels were never on.
            assert_eq!([at(0, 2), at(2, 0), at(size.rows() - 1, 0)], [0; 3]);
            [at(0, 0), at(0, 1), at(1, 0), at(1, 1)]
        })
        .collect()
}

fn of_four(kind: TemplateKind) -> heapless::Vec<[u8; 4], 3> {
    let found = Size::ALL.map(|size| corners(TemplateBuilder::for_kind(kind, size, 4), &FOUR));
    assert!(found.iter().all(|other| *other == found[0]));
    found[0].clone()
}

#[test]
fn four_frames_of_two_by_two_pixels_are_what_can_be_worked_out_by_hand() {
    // The means are 1, 1/2, 0 and 3/4.
    assert_eq!(of_four(TemplateKind::Gei), [[255, 128, 0, 191]]);
    // The second pixel changes in all three steps, the fourth in the first two.
    assert_eq!(of_four(TemplateKind::Mei), [[0, 255, 0, 255]]);
    // 3/3 and 2/3.
    assert_eq!(of_four(TemplateKind::Mhi), [[0, 255, 0, 170]]);
    assert_eq!(of_four(TemplateKind::Msi), [[255, 255, 0, 255]]);
    // Always; 3/3 (1 - 1/3); never; 2/3 (1 - 1/3): 2/3 and 4/9 of 255.
    assert_eq!(of_four(TemplateKind::Ghi), [[255, 170, 0, 113]]);
    // Entropies 0, 1, 0 and 0.811278 bits.
    assert_eq!(of_four(TemplateKind::Geni), [[0, 255, 0, 207]]);
    // Amplitudes 0, 0, 0, 1/4 and 0, 1/2, 0, 1/4.
    let expected = [[255, 128, 0, 191], [0, 0, 0, 64], [0, 128, 0, 64]];
    assert_eq!(of_four(TemplateKind::Frequency), expected);
}

#[test]
fn motion_fades_over_the_planned_steps() {
    let of =
        |kind, frames| corners(TemplateBuilder::for_kind(kind, Size::S50x30, frames), &FOUR)[0];
    // The fourth pixel moved one step before the last: 9/10 of ten steps are left.
    assert_eq!(of(TemplateKind::Mhi, 11), [0, 255, 0, 230]);
    assert_eq!(of(TemplateKind::Mei, 11), [0, 255, 0, 255]);
}

#[test]
fn a_silhouette_fades_from_the_last_frame_that_it_is_in() {
    let builder = TemplateBuilder::for_kind(TemplateKind::Msi, Size::S50x30, 4);
    let gone = [[0b11, 0], [0b01, 0], [0b01, 0], [0, 0]];
    assert_eq!(corners(builder, &gone), [[254, 252, 0, 0]]);
}

#[test]
fn what_never_changes_has_no_motion_and_no_entropy() {
    let still = [[0b11, 0b11]; 4];
    for (kind, expected) in [
        (TemplateKind::Gei, 255),
        (TemplateKind::Mei, 0),
        (TemplateKind::Mhi, 0),
        (TemplateKind::Msi, 255),
        (TemplateKind::Ghi, 255),
        (TemplateKind::Geni, 0),
    ] {
        let builder = TemplateBuilder::for_kind(kind, Size::S64x44, 4);
        assert_eq!(corners(builder, &still), [[expected; 4]], "{kind:?}");
    }
    let builder = TemplateBuilder::for_kind(TemplateKind::Frequency, Size::S64x44, 4);
    assert_eq!(corners(builder, &still), [[255; 4], [0; 4], [0; 4]]);
}

#[test]
fn frames_of_another_size_and_more_than_were_to_come_are_refused() {
    for kind in TemplateKind::ALL {
        let mut builder = TemplateBuilder::for_kind(kind, Size::S50x30, 2);
        let refused = builder.add(&AnySilhouette::Binary(Silhouette::empty(Size::S64x64)));
        let (expected, found) = (Size::S50x30, Size::S64x64);
        assert_eq!(refused, Err(FrameError::Size { expected, found }));
        assert_eq!(builder.frames(), 0);
        let mut bytes = [7; 3 * 1500];
        builder.finish(&mut bytes);
        let (template, rest) = bytes.split_at(kind.bytes(Size::S50x30));
        assert!(template.iter().all(|&byte| byte == 0), "{kind:?}");
        assert!(rest.iter().all(|&byte| byte == 7), "{kind:?}");
        let frame = AnySilhouette::Binary(Silhouette::from_rows(Size::S50x30, &[1]));
        assert_eq!([builder.add(&frame), builder.add(&frame)], [Ok(()); 2]);
        assert_eq!(builder.add(&frame), Err(FrameError::Full { frames: 2 }));
        assert_eq!(builder.frames(), 2);
        builder.finish(&mut []);
    }
}

#[test]
fn a_cleared_builder_is_as_a_new_one() {
    for kind in TemplateKind::ALL {
        let mut used = TemplateBuilder::for_kind(kind, Size::S50x30, 4);
        for rows in FOUR {
            let frame = Silhouette::from_rows(Size::S50x30, &[!rows[0], !0, rows[1]]);
            used.add(&AnySilhouette::Binary(frame)).expect("room");
        }
        used.clear();
        assert_eq!(used.frames(), 0);
        let new = TemplateBuilder::for_kind(kind, Size::S50x30, 4);
        assert_eq!(corners(used, &FOUR), corners(new, &FOUR), "{kind:?}");
    }
}
