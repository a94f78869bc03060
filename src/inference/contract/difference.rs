//! The difference of two contracts in inputs and promises.

use super::Contract;

impl Contract {
    /// Returns the first setting that prevents comparing two models of these contracts number by
    /// number, with both its values. Training viewpoints matter, since people are enrolled from
    /// them; names and other training data do not.
    #[must_use]
    pub(crate) fn difference(&self, other: &Self) -> Option<(&'static str, [String; 2])> {
        type Value = fn(&Contract) -> String;
        let settings: [(&'static str, Value); 13] = [
            ("template", |contract| contract.template.name().into()),
            ("size", |contract| {
                format!("{}x{}", contract.rows, contract.columns)
            }),
            ("layout", |contract| contract.layout.name().into()),
            ("framing", |contract| contract.framing.name().into()),
            ("input_range", |contract| contract.input_range.name().into()),
            ("mean", |contract| format!("{:?}", contract.mean)),
            ("std", |contract| format!("{:?}", contract.std)),
            ("channels", |contract| contract.channels.to_string()),
            ("frames", |contract| match contract.frames {
                Some(frames) => frames.to_string(),
                None => "any number".into(),
            }),
            ("view_input", |contract| {
                contract.view_input.clone().unwrap_or_else(|| "none".into())
            }),
            ("distance", |contract| contract.distance.name().into()),
            ("number of classes", |contract| {
                contract.classes.len().to_string()
            }),
            ("training.viewpoints", |contract| {
                format!("{:?}", contract.training.viewpoints)
            }),
        ];
        for (setting, value) in settings {
            let values = [value(self), value(other)];
            if values[0] != values[1] {
                return Some((setting, values));
            }
        }
        let classes = self.classes.iter().zip(&other.classes).enumerate();
        let mut different = classes.filter(|(_, (one, other))| one != other);
        different.next().map(|(at, (one, other))| {
            let named = |name: &String| format!("{name:?} as number {at}");
            ("classes", [named(one), named(other)])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::sweep::FramingMode;
    use crate::draw::template::Template;
    use crate::inference::{Distance, InputLayout, InputRange};

    type Change = fn(&mut Contract);

    #[test]
    fn the_first_setting_that_differs_is_named_with_both_values() {
        let usual = Contract {
            classes: vec!["ann".into(), "bob".into()],
            ..Contract::default()
        };
        let with = |change: fn(&mut Contract)| {
            let mut other = usual.clone();
            change(&mut other);
            let found = usual.difference(&other);
            found.map(|(setting, [a, b])| format!("{setting}: {a}, {b}"))
        };
        let cases: [(Change, &str); 10] = [
            (|c| c.template = Template::Mhi, "template: gei, mhi"),
            (|c| c.rows = 64, "size: 50x30, 64x30"),
            (|c| c.layout = InputLayout::Nhwc, "layout: NCHW, NHWC"),
            (|c| c.framing = FramingMode::Box, "framing: height, box"),
            (
                |c| c.input_range = InputRange::Byte,
                "input_range: 0..1, 0..255",
            ),
            (|c| c.frames = Some(30), "frames: any number, 30"),
            (
                |c| c.distance = Distance::Cosine,
                "distance: euclidean, cosine",
            ),
            (|c| c.classes.clear(), "number of classes: 2, 0"),
            (
                |c| c.classes.swap(0, 1),
                "classes: \"ann\" as number 0, \"bob\" as number 0",
            ),
            (
                |c| c.training.viewpoints.push([90.0, 0.0]),
                "training.viewpoints: [], [[90.0, 0.0]]",
            ),
        ];
        for (change, expected) in cases {
            assert_eq!(with(change).as_deref(), Some(expected));
        }
        assert_eq!(with(|c| c.name = "other".into()), None);
        assert_eq!(with(|c| c.training.seed = 7), None);
    }
}
