//! The values of flags that the library names, with their help texts.

use crate::bench::TableFormat;
use crate::dataset::DatasetFormat;
use crate::draw::sweep::{FramingMode, Jitter, Lens};
use crate::draw::template::Template;
use crate::inference::Provider;
use crate::people::cohort::{Dressing, ReferencePopulation};
use clap::ValueEnum;
use clap::builder::PossibleValue;
use edgegait_core::pack::Sex;

/// Implements [`ValueEnum`] with the library's names.
macro_rules! values {
    ($type:ty { $($variant:ident$(: $help:literal)?,)* }) => {
        impl ValueEnum for $type {
            fn value_variants<'a>() -> &'a [Self] {
                &[$(Self::$variant),*]
            }

            fn to_possible_value(&self) -> Option<PossibleValue> {
                let value = PossibleValue::new(self.name());
                Some(match self {
                    $(Self::$variant => value$(.help($help))?,)*
                })
            }
        }
    };
}

/// Sexes on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum SexArg {
    Female,
    Male,
}

impl SexArg {
    /// Returns the sex.
    pub(super) const fn sex(self) -> Sex {
        match self {
            Self::Female => Sex::Female,
            Self::Male => Sex::Male,
        }
    }
}

values!(DatasetFormat {
    Folder,
    Npz,
    Opengait,
    CasiaB,
});

values!(Dressing {
    ForGood: "Once: the same clothes in all takes",
    PerTake: "For each take; packs store the outfits as further bodies",
});

values!(ReferencePopulation {
    UsArmy: "Soldiers of the United States (ANSUR II)",
    Britain: "British adults of 19 to 65 years (Pheasant & Haslegrave 2006)",
    China: "Chinese adults of 18 to 60 years (GB/T 10000-1988)",
});

values!(FramingMode {
    Height: "Each frame fills the rows, centred on its centroid",
    Box: "Each frame is stretched to its bounding box",
    Cycle: "One scale and centre for a whole cycle and all elevations",
    Camera: "The image of a sensor at the viewpoint",
});

values!(Lens {
    Ortho: "Parallel rays",
    Persp: "Perspective, from one point",
});

values!(Jitter {
    None: "At the pixel's centre",
    R2: "At a different point of the R2 sequence for each frame (Roberts 2018)",
});

values!(Template {
    Silhouettes: "The silhouettes themselves, one after another",
    Gei: "Gait Energy Image: the mean (Han & Bhanu 2006)",
    Mei: "Motion Energy Image: where anything moved (Bobick & Davis 2001)",
    Mhi: "Motion History Image: how recently it moved (Bobick & Davis 2001)",
    Msi: "Motion Silhouette Image: how recently the figure was there (Lam & Lee 2006)",
    Ghi: "In the style of the Gait History Image: what stays still, and when the rest last moved (Liu & Zheng 2007)",
    Geni: "Gait Entropy Image: how uncertain each pixel is (Bashir, Xiang & Gong 2009)",
    Frequency: "Amplitudes of the frequencies 0, 1 and 2 of a cycle, stacked (Makihara et al. 2006)",
    Kfd: "Vector of the outline in the style of Key Fourier Descriptors (Yu et al. 2004)",
    RowWidth: "Vector with the width of each row of the GEnI (after Nandy et al.)",
});

values!(Provider {
    Cpu: "The CPU, in every library",
    Xnnpack: "XNNPACK: Google's kernels for the CPU",
    Acl: "Arm Compute Library",
    Armnn: "Arm NN",
    Nnapi: "Android's Neural Networks API",
    Coreml: "Apple's Core ML",
    Qnn: "Qualcomm AI Engine Direct",
    Rknpu: "Rockchip's NPU",
    Cuda: "Nvidia GPUs",
    Tensorrt: "Nvidia TensorRT",
    Openvino: "Intel OpenVINO",
});

values!(TableFormat {
    Text: "Aligned columns",
    Markdown: "Markdown tables",
});
