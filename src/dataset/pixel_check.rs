//! Checks that pictures are silhouettes: white figures on black, without grey areas.

/// The share of the border that is on from which the figure is taken to be black on white. Our
/// choice: a figure that is cropped to its box touches less than half of its border.
const MOST_BORDER: f64 = 0.5;
/// The share of a figure in grey areas from which it is none of a mask. Our choice.
const MOST_GREY: f64 = 0.1;
/// Sixteenths of the brightest pixel between which a pixel is grey. Our choice: the noise of JPEG
/// lies outside. Some masks have another white than 255.
const GREY: (u16, u16) = (3, 13);

/// The counts of pixels in the pictures of a sequence.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PixelCheck {
    /// Pixels of the border, and those of them that are on.
    border: u64,
    border_on: u64,
    /// Pixels that are off.
    off: u64,
    /// Grey and brighter pixels, and those of them in grey areas: all eight neighbours are grey too.
    figure: u64,
    grey: u64,
}

impl PixelCheck {
    /// Counts the pixels of one more picture, rows from the top.
    pub(super) fn add(&mut self, pixels: &[u8], columns: usize) {
        let rows: Vec<&[u8]> = pixels.chunks_exact(columns.max(1)).collect();
        let on = |pixel: &&u8| **pixel >= 128;
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
            return;
        };
        let sides = rows.iter().flat_map(|row| [row.first(), row.last()]);
        self.border_on += (first.iter().chain(*last).filter(on).count()
            + sides.flatten().filter(on).count()) as u64;
        self.off += pixels.iter().filter(|pixel| !on(pixel)).count() as u64;
        self.border += 2 * (columns + rows.len()) as u64;
        let brightest = pixels.iter().copied().max().unwrap_or(0);
        if !on(&&brightest) {
            return;
        }
        let [low, high] = [GREY.0, GREY.1].map(|part| u16::from(brightest) * part / 16);
        let is_grey = |pixel: &u8| (low..=high).contains(&u16::from(*pixel));
        let figure = pixels.iter().filter(|pixel| u16::from(**pixel) >= low);
        self.figure += figure.count() as u64;
        if !pixels.iter().any(is_grey) {
            return;
        }
        for three in rows.windows(3) {
            for at in 1..columns.saturating_sub(1) {
                let is_area = is_grey(&three[1][at])
                    && three
                        .iter()
                        .all(|row| row[at - 1..=at + 1].iter().all(is_grey));
                self.grey += u64::from(is_area);
            }
        }
    }

    /// Returns why the pictures are not white on black, if they are not.
    pub(super) fn inverted(&self) -> Option<String> {
        let share = self.border_on as f64 / self.border.max(1) as f64;
        // Without any pixel off there is no figure either way.
        (share > MOST_BORDER && self.off > 0).then(|| {
            format!(
                "expected a white figure on black, found {:.0} % of the border of its pictures white (invert them)",
                100.0 * share
            )
        })
    }

    /// Returns why the pictures are not masks, if they are not.
    pub(super) fn grey(&self) -> Option<String> {
        let share = self.grey as f64 / self.figure.max(1) as f64;
        (share > MOST_GREY).then(|| {
            format!(
                "expected silhouettes, whose pixels are black or white, found {:.0} % of the figure within grey areas (templates such as GEIs go into geis.npy with an index.csv; photographs need segmentation, and soft masks a threshold)",
                100.0 * share
            )
        })
    }
}

/// Checks that a GEI is white on black, with numbers from 0 to 255.
pub(super) fn check_gei(gei: &[u8], columns: usize) -> Result<(), String> {
    if gei.iter().max() == Some(&1) {
        return Err("expected pixels from 0 to 255, found only 0 and 1: of numbers from 0 to 1, the fractions are lost (save (255 * x).round().astype('uint8') of the original)".into());
    }
    let mut check = PixelCheck::default();
    check.add(gei, columns);
    check.inverted().map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc of radius `radius` in 60x60 pixels, whose edge is `soft` pixels wide.
    fn disc(radius: f64, soft: f64) -> Vec<u8> {
        let pixel = |at: usize| {
            let (x, y) = ((at % 60) as f64 - 29.5, (at / 60) as f64 - 29.5);
            let inside = (radius - x.hypot(y)) / soft + 0.5;
            (255.0 * inside.clamp(0.0, 1.0)) as u8
        };
        (0..3600).map(pixel).collect()
    }

    fn checked(pixels: &[u8]) -> PixelCheck {
        let mut check = PixelCheck::default();
        check.add(pixels, 60);
        check
    }

    #[test]
    fn masks_with_soft_edges_are_masks() {
        for (radius, soft) in [
            (20.0, 0.01),
            (20.0, 1.0),
            (20.0, 3.0),
            (8.0, 1.0),
            (8.0, 2.0),
        ] {
            let check = checked(&disc(radius, soft));
            let dim: Vec<u8> = disc(radius, soft)
                .iter()
                .map(|pixel| pixel / 2 + 1)
                .collect();
            assert_eq!(checked(&dim).grey(), None, "{radius} {soft}");
            assert_eq!(
                (check.grey(), check.inverted()),
                (None, None),
                "{radius} {soft}"
            );
        }
    }

    #[test]
    fn grey_areas_and_white_borders_are_found() {
        // Half of the disc is of the grey of a leg that is there in half of the frames.
        let mut gei = disc(20.0, 1.0);
        gei[1800..].iter_mut().for_each(|pixel| *pixel /= 2);
        assert!(checked(&gei).grey().expect("grey").contains("geis.npy"));
        let ramp: Vec<u8> = (0..3600).map(|at| (at % 60 * 4) as u8).collect();
        assert!(checked(&ramp).grey().is_some());
        let inverted: Vec<u8> = disc(20.0, 1.0).iter().map(|pixel| 255 - pixel).collect();
        let text = checked(&inverted).inverted().expect("inverted");
        assert!(text.contains("100 % of the border"), "{text}");
        // A figure that is cropped to its box, as wide as high.
        assert_eq!(checked(&disc(30.0, 0.01)).inverted(), None);
    }

    #[test]
    fn pictures_of_any_size_are_counted() {
        for (pixels, columns) in [
            (&[][..], 5),
            (&[255][..], 1),
            (&[255, 0, 100], 3),
            (&[9, 9], 1),
        ] {
            PixelCheck::default().add(pixels, columns);
        }
        PixelCheck::default().add(&[], 0);
    }
}
