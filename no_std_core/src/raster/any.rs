//! A window whose rasteriser is chosen at run time.

use super::moments::AreaMoments;
use super::placement::{Extent, Placement};
use super::rows::{self, Sampling};
use super::skia_lanes::SkiaLanes;
#[cfg(feature = "tiny-skia")]
use super::tiny_skia::TinySkia;
use super::window::{Fill, Pixels};
use super::{DrawError, Rasterizer, RenderView};
use crate::body::Figure;
use crate::camera::Camera;
#[cfg(feature = "tiny-skia")]
use crate::silhouette::Coverage;
use crate::silhouette::{AnySilhouette, Silhouette, Size};
use crate::simd::Simd;

/// The window of any rasteriser, for figures of unpacked bodies. 34 kB.
#[derive(Debug)]
pub struct AnyWindow(AnyKind);

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "34 kB once for a renderer; a box would need a heap"
)]
enum AnyKind {
    Skia(SkiaLanes),
    #[cfg(feature = "tiny-skia")]
    TinySkia(TinySkia),
    #[cfg(feature = "tiny-skia")]
    SkiaAa(TinySkia<Coverage>),
    Rows(rows::BitWindow),
}

impl AnyWindow {
    pub(super) fn new(rasterizer: Rasterizer, size: Size, simd: Simd) -> Self {
        let rows = |sampling| AnyKind::Rows(rows::BitWindow::new(size, sampling, simd));
        Self(match rasterizer {
            Rasterizer::Skia => AnyKind::Skia(SkiaLanes::new(size, simd)),
            #[cfg(feature = "tiny-skia")]
            Rasterizer::TinySkia => AnyKind::TinySkia(TinySkia::new(size)),
            #[cfg(feature = "tiny-skia")]
            Rasterizer::SkiaAa => AnyKind::SkiaAa(TinySkia::anti_aliased(size)),
            Rasterizer::Rows => rows(Sampling::Once),
            Rasterizer::Rows3x3 => rows(Sampling::ThreeByThree),
        })
    }
}

/// Evaluates an expression with the window in use, whichever it is.
macro_rules! each {
    ($self:ident, $window:ident => $does:expr) => {
        match &$self.0 {
            AnyKind::Skia($window) => $does,
            #[cfg(feature = "tiny-skia")]
            AnyKind::TinySkia($window) => $does,
            #[cfg(feature = "tiny-skia")]
            AnyKind::SkiaAa($window) => $does,
            AnyKind::Rows($window) => $does,
        }
    };
    (mut $self:ident, $window:ident => $does:expr) => {
        match &mut $self.0 {
            AnyKind::Skia($window) => $does,
            #[cfg(feature = "tiny-skia")]
            AnyKind::TinySkia($window) => $does,
            #[cfg(feature = "tiny-skia")]
            AnyKind::SkiaAa($window) => $does,
            AnyKind::Rows($window) => $does,
        }
    };
}

impl Pixels for AnyWindow {
    type Image = AnySilhouette;

    fn blank(&self) -> AnySilhouette {
        AnySilhouette::Binary(Silhouette::empty(self.size()))
    }
    fn rasterizer(&self) -> Rasterizer {
        each!(self, window => window.rasterizer())
    }
    fn size(&self) -> Size {
        each!(self, window => window.size())
    }
    fn width(&self) -> usize {
        each!(self, window => window.width())
    }
    fn columns(&self, columns: f32) -> usize {
        each!(self, window => window.columns(columns))
    }
    fn clear(&mut self) {
        each!(mut self, window => window.clear());
    }
    fn moments(&self) -> AreaMoments {
        each!(self, window => window.moments())
    }
    fn cut(&self, left: isize, frame: &mut AnySilhouette) -> u64 {
        match &self.0 {
            AnyKind::Skia(window) => cut_binary(window, left, frame),
            #[cfg(feature = "tiny-skia")]
            AnyKind::TinySkia(window) => cut_binary(window, left, frame),
            #[cfg(feature = "tiny-skia")]
            AnyKind::SkiaAa(window) => {
                let mut coverage = window.blank();
                let area = window.cut(left, &mut coverage);
                *frame = AnySilhouette::Grey(coverage);
                area
            }
            AnyKind::Rows(window) => window.cut(left, frame),
        }
    }
}

/// Cuts out columns without copying unused parts of a frame.
fn cut_binary(
    window: &impl Pixels<Image = Silhouette>,
    left: isize,
    frame: &mut AnySilhouette,
) -> u64 {
    if !matches!(frame, AnySilhouette::Binary(_)) {
        *frame = AnySilhouette::Binary(window.blank());
    }
    match frame {
        AnySilhouette::Binary(silhouette) => window.cut(left, silhouette),
        _ => 0,
    }
}

impl<'a> Fill<Figure<'a>> for AnyWindow {
    fn look(&mut self, figure: &Figure<'a>, views: &[RenderView]) {
        each!(mut self, window => window.look(figure, views));
    }
    fn extent(&mut self, figure: &Figure<'a>, camera: &Camera) -> Result<Extent, DrawError> {
        each!(mut self, window => Fill::extent(window, figure, camera))
    }
    fn draw(
        &mut self,
        figure: &Figure<'a>,
        camera: &Camera,
        view: usize,
        placement: &Placement,
        columns: usize,
    ) {
        each!(mut self, window => Fill::draw(window, figure, camera, view, placement, columns));
    }
}
