//! The Rice parameters of a pack, which make its clips shortest.

use super::bits::{BitWriter, rice_bits};
use super::coefficients::CycleCoefficients;
use edgegait_core::format::{
    CHANNELS, DIRECT_CODES, GROUPS_BITS, GROUPS_RICE_BITS, MAX_RICE, RICE_BITS,
};
use serde::{Deserialize, Serialize};

/// The Rice parameters of all channels.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct RiceParameters {
    channels: Vec<ChannelRice>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct ChannelRice {
    usual_groups: u32,
    groups_rice: u32,
    /// The Rice parameter of each group.
    rice: Vec<u32>,
}

/// Returns the number of groups that a channel's numbers fill.
fn groups_of(numbers: &[i32]) -> usize {
    numbers.len().div_ceil(2) + usize::from(!numbers.is_empty() && numbers.len().is_multiple_of(2))
}

/// Returns the numbers of a group: the constant, or a cosine and a sine.
fn group(numbers: &[i32], group: usize) -> &[i32] {
    let range = if group == 0 {
        0..1
    } else {
        2 * group - 1..2 * group + 1
    };
    numbers.get(range).unwrap_or_default()
}

fn difference(groups: usize, usual: u32) -> i32 {
    i32::try_from(groups).unwrap_or(i32::MAX) - usual.cast_signed()
}

impl RiceParameters {
    /// Returns the parameters that make these clips shortest. Mean walks only add groups.
    pub(super) fn fit(clips: &[&CycleCoefficients], templates: &[CycleCoefficients]) -> Self {
        let channels = (0..CHANNELS).map(|channel| {
            let own: Vec<&[i32]> = clips.iter().map(|clip| clip[channel].as_slice()).collect();
            let usual = templates.iter().map(|numbers| numbers[channel].as_slice());
            ChannelRice::fit(&own, usual.map(groups_of).max().unwrap_or(0))
        });
        Self {
            channels: channels.collect(),
        }
    }

    /// Extends the parameters for clips with as many groups as the format holds.
    #[cfg(test)]
    pub(super) fn open(mut self) -> Self {
        for channel in &mut self.channels {
            channel.rice.resize(edgegait_core::format::MAX_GROUPS, 0);
        }
        self
    }

    /// Returns the number of channels.
    pub(super) const fn channels(&self) -> usize {
        self.channels.len()
    }

    /// Returns the number of bits of a clip's stream.
    pub(super) fn clip_bits(&self, numbers: &CycleCoefficients) -> u32 {
        let channels = self.channels.iter().zip(numbers);
        let of = |(channel, numbers): (&ChannelRice, &Vec<i32>)| {
            let groups = groups_of(numbers);
            let count = rice_bits(
                difference(groups, channel.usual_groups),
                channel.groups_rice,
            );
            let own = channel.rice.iter().enumerate().take(groups);
            let own = own.flat_map(|(index, &parameter)| {
                let group = group(numbers, index).iter();
                group.map(move |&number| rice_bits(number, parameter))
            });
            count + own.sum::<u32>()
        };
        channels.map(of).sum()
    }

    /// Returns the table of the codebook.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut bits = BitWriter::default();
        for channel in &self.channels {
            channel.write(&mut bits);
        }
        bits.into_bytes()
    }

    /// Writes a clip's bit stream.
    pub(super) fn write_clip(&self, numbers: &CycleCoefficients) -> Vec<u8> {
        let mut bits = BitWriter::default();
        for (channel, numbers) in self.channels.iter().zip(numbers) {
            if channel.rice.is_empty() {
                continue;
            }
            let groups = groups_of(numbers);
            bits.rice(
                difference(groups, channel.usual_groups),
                channel.groups_rice,
            );
            for (index, &parameter) in channel.rice.iter().enumerate().take(groups) {
                for &number in group(numbers, index) {
                    bits.rice(number, parameter);
                }
            }
        }
        bits.into_bytes()
    }

    /// Writes a mean walk's bit stream.
    pub(super) fn write_template(&self, numbers: &CycleCoefficients) -> Vec<u8> {
        let mut bits = BitWriter::default();
        for (channel, numbers) in self.channels.iter().zip(numbers) {
            if channel.rice.is_empty() {
                continue;
            }
            let groups = groups_of(numbers);
            let all = |larger: u32| {
                channel
                    .rice
                    .iter()
                    .enumerate()
                    .take(groups)
                    .flat_map(move |(index, &rice)| {
                        let parameter = (rice + larger).min(MAX_RICE);
                        group(numbers, index)
                            .iter()
                            .map(move |&number| (number, parameter))
                    })
            };
            let cost = |larger: &u32| -> u32 { all(*larger).map(|(n, p)| rice_bits(n, p)).sum() };
            let larger = (0..=MAX_RICE).min_by_key(cost).unwrap_or(0);
            #[expect(clippy::cast_possible_truncation, reason = "at most 32")]
            bits.unsigned(groups as u32, GROUPS_BITS);
            bits.unsigned(larger, RICE_BITS);
            for (number, parameter) in all(larger) {
                bits.rice(number, parameter);
            }
        }
        bits.into_bytes()
    }
}

impl ChannelRice {
    fn fit(clips: &[&[i32]], template_groups: usize) -> Self {
        let counts: Vec<usize> = clips.iter().map(|numbers| groups_of(numbers)).collect();
        let most = counts
            .iter()
            .copied()
            .max()
            .unwrap_or(0)
            .max(template_groups);
        let mut best = (u32::MAX, 0, 0);
        for usual in 0..=u32::try_from(most).unwrap_or(0) {
            for rice in 0..1 << GROUPS_RICE_BITS {
                let bits = counts
                    .iter()
                    .map(|&groups| rice_bits(difference(groups, usual), rice));
                best = best.min((bits.sum(), usual, rice));
            }
        }
        Self {
            usual_groups: best.1,
            groups_rice: best.2,
            rice: shortest(most, |index, parameter| {
                let numbers = clips.iter().flat_map(|numbers| group(numbers, index));
                numbers.map(|&number| rice_bits(number, parameter)).sum()
            }),
        }
    }

    fn write(&self, bits: &mut BitWriter) {
        #[expect(clippy::cast_possible_truncation, reason = "at most 32")]
        bits.unsigned(self.rice.len() as u32, GROUPS_BITS);
        if self.rice.is_empty() {
            return;
        }
        bits.unsigned(self.usual_groups, GROUPS_BITS);
        bits.unsigned(self.groups_rice, GROUPS_RICE_BITS);
        let mut last = 0;
        for (index, &parameter) in self.rice.iter().enumerate() {
            if index < DIRECT_CODES {
                bits.unsigned(parameter, RICE_BITS);
            } else {
                bits.rice(fall(last, parameter), 0);
            }
            last = parameter;
        }
    }
}

/// Returns the fall of the Rice parameter from one group to the next.
fn fall(before: u32, after: u32) -> i32 {
    before.cast_signed() - after.cast_signed()
}

/// Returns one Rice parameter for each group, with the fewest bits for the numbers (`cost`, by
/// group and parameter) and the parameters themselves (Viterbi 1967).
fn shortest(groups: usize, cost: impl Fn(usize, u32) -> u32) -> Vec<u32> {
    const STATES: u32 = MAX_RICE + 1;
    let mut sums = vec![0u32; STATES as usize];
    let mut came_from: Vec<Vec<u32>> = Vec::new();
    for index in 0..groups {
        let (mut next, mut from) = (Vec::new(), Vec::new());
        for parameter in 0..STATES {
            let reached = (0..STATES).map(|before| {
                let own = if index < DIRECT_CODES {
                    RICE_BITS
                } else {
                    rice_bits(fall(before, parameter), 0)
                };
                (sums[before as usize] + own, before)
            });
            let (bits, before) = reached.min().unwrap_or_default();
            next.push(bits + cost(index, parameter));
            from.push(before);
        }
        sums = next;
        came_from.push(from);
    }
    let mut state = (0..STATES)
        .min_by_key(|&state| sums[state as usize])
        .unwrap_or(0);
    let mut parameters = Vec::new();
    for from in came_from.iter().rev() {
        parameters.push(state);
        state = from[state as usize];
    }
    parameters.reverse();
    parameters
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_a_constant_and_pairs() {
        assert_eq!([0, 1, 3, 5].map(|n| groups_of(&vec![1; n])), [0, 1, 2, 3]);
        assert_eq!(group(&[7, 1, 2, 3, 4], 2), [3, 4]);
        assert_eq!(group(&[7], 1), [0i32; 0]);
    }

    #[test]
    fn parameters_follow_the_numbers_but_not_at_any_price() {
        // 100 numbers of about 64 in group 0 and 1, and only one in group 2.
        let numbers: Vec<Vec<i32>> = (0..100)
            .map(|i| vec![64 - i % 3, -63, 62, i32::from(i == 5), 0])
            .collect();
        let slices: Vec<&[i32]> = numbers.iter().map(Vec::as_slice).collect();
        let channel = ChannelRice::fit(&slices, 0);
        assert_eq!(channel.rice, [6, 6, 0]);
        assert_eq!((channel.usual_groups, channel.groups_rice), (3, 0));
    }
}
