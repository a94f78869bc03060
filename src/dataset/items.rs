//! A dataset that is rendered on demand: any of its items, in any order, by their numbers.
//!
//! Renders the items that [`DatasetWriter`](super::DatasetWriter) would store for a design or a
//! sweep, one item or batch at a time, and never stores them. The bytes of an item depend only on
//! its number, the seed and the pass, not on the batch.

mod drawn;
mod shares;

pub use drawn::DrawnItems;

use super::contents::Array;
use super::{Contents, IndexRow, ItemOrder};
use crate::dataset::design::Design;
use crate::draw::confounders::Condition;
use crate::draw::sweep::{Drawer, Job, Settings, Swept, View, Wanted, is_uncut};
use crate::encode::{Effort, MAX_ERROR_MM, encode_population};
use crate::error::{ChoiceError, Error, Result};
use crate::people::cohort;
use crate::people::variation::CYCLES_OF_A_TAKE;
use drawn::ItemBytes;
use edgegait_core::pack::Pack;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// The first variation of passes after the first. It is beyond those that commands and protocols
/// can name, so that no pass draws test data.
const FIRST_OF_PASSES: u32 = 1 << 20;

/// The maximum numbers of bytes and of items in one call. Item numbers are listed in memory.
const MAX_BYTES: usize = 1 << 31;
const MAX_ITEMS: usize = 1 << 24;

/// The shared bytes of a pack that [`Pack::parse`] accepts.
pub type PackBytes = Arc<[u8]>;

/// The items of a dataset that is rendered on demand: each is a gait cycle or an uncut motion seen
/// from one viewpoint.
#[derive(Clone, Debug)]
pub struct Items {
    origin: ItemOrigin,
    settings: Settings,
    wanted: Wanted,
}

/// The source of items.
#[derive(Clone, Debug)]
enum ItemOrigin {
    /// People of a design, who are made when they are needed.
    Design {
        design: Box<Design>,
        /// The numbers of the people in the design.
        people: Range<usize>,
    },
    /// Walks of a pack.
    Pack {
        items: Box<PackItems>,
        /// The names of the people, each once, in the order of their first walk.
        subjects: Vec<String>,
        /// The index in `subjects` of each walk's person.
        labels: Vec<usize>,
    },
}

/// The walks of a pack to draw, and their conditions, variations and viewpoints.
#[derive(Clone, Debug)]
pub struct PackItems {
    /// The pack.
    pub bytes: PackBytes,
    /// The numbers of the walks in the pack.
    pub walks: Vec<usize>,
    /// The conditions of each walk; if empty, walks are drawn as they are.
    pub conditions: Vec<Condition>,
    /// The variations of each walk.
    pub variations: Range<u32>,
    /// The viewpoints of each walk.
    pub views: Vec<View>,
}

/// The person and cycle of an item.
#[derive(Clone, Copy)]
struct ItemCycle {
    /// The number of the person in the list; 0 for a pack.
    person: usize,
    /// The number of the cycle, of that person or in the pack.
    cycle: usize,
}

impl Items {
    /// Returns the items of a design's people: those of the split of this name, if the design has
    /// named splits, and at most `most` people.
    ///
    /// # Errors
    /// If there is no such split, or there are several and none is named.
    pub fn of_design(design: Design, split: Option<&str>, most: Option<usize>) -> Result<Self> {
        let known = |name: &Option<String>| name.as_deref() == split;
        let Some(found) = design.splits.iter().find(|split| known(&split.name)) else {
            let names = design.splits.iter().filter_map(|split| split.name.clone());
            return Err(ChoiceError::NoSplit {
                name: split.map(str::to_owned),
                known: names.collect(),
            }
            .into());
        };
        let Range { start, end } = found.people;
        let people = start..end.min(start.saturating_add(most.unwrap_or(usize::MAX)));
        Ok(Self {
            settings: design.settings,
            wanted: design.images.wanted.clone(),
            origin: ItemOrigin::Design {
                people,
                design: Box::new(design),
            },
        })
    }

    /// Returns the items of a pack's walks.
    ///
    /// # Errors
    /// If the bytes are not a pack, or the wanted templates cannot be drawn.
    pub fn of_pack(items: PackItems, settings: Settings, wanted: Wanted) -> Result<Self> {
        let pack = Pack::parse(&items.bytes)?;
        Drawer::new(settings, &wanted)?;
        let (mut numbers, mut labels) = (HashMap::new(), Vec::new());
        let mut subjects = Vec::new();
        for &number in &items.walks {
            let subject = pack
                .walk(number)
                .and_then(|walk| pack.subject(walk.subject));
            let name = subject.map_or("", |subject| subject.name);
            labels.push(*numbers.entry(name).or_insert_with(|| {
                subjects.push(name.to_owned());
                subjects.len() - 1
            }));
        }
        Ok(Self {
            origin: ItemOrigin::Pack {
                items: Box::new(items),
                subjects,
                labels,
            },
            settings,
            wanted,
        })
    }

    /// Returns the number of items.
    #[must_use]
    pub fn len(&self) -> usize {
        self.people() * self.cycles() * self.views()
    }

    /// Returns whether there are no items.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of viewpoints, and so of items, of each cycle.
    #[must_use]
    pub fn views(&self) -> usize {
        match &self.origin {
            ItemOrigin::Design { design, .. } => design.viewpoints(),
            ItemOrigin::Pack { items, .. } => items.views.len(),
        }
    }

    /// Returns the number of people that are made for the items; 1 for a pack.
    #[must_use]
    pub fn people(&self) -> usize {
        match &self.origin {
            ItemOrigin::Design { people, .. } => people.len(),
            ItemOrigin::Pack { .. } => 1,
        }
    }

    /// Returns the maximum number of items of one frame each that one call can draw in 2 GiB of
    /// results. [`Self::draw`] counts further frames too.
    #[must_use]
    pub fn most_at_once(&self) -> usize {
        (MAX_BYTES / self.bytes(1).max(1)).clamp(1, MAX_ITEMS)
    }

    /// Returns the number of bytes of an item with this number of frames.
    fn bytes(&self, frames: u32) -> usize {
        let arrays = self.arrays();
        arrays.iter().map(|array| array.bytes_of(frames)).sum()
    }

    /// Returns the number of cycles of each person.
    fn cycles(&self) -> usize {
        match &self.origin {
            ItemOrigin::Design { design, .. } => design.cycles(),
            ItemOrigin::Pack { items, .. } => {
                items.walks.len() * items.conditions.len().max(1) * items.variations.len()
            }
        }
    }

    /// Returns the arrays of each item.
    #[must_use]
    pub fn arrays(&self) -> Vec<Array> {
        let contents = Contents {
            templates: self.wanted.templates.clone(),
            size: self.settings.size,
            joints: self.wanted.joints,
        };
        contents.arrays()
    }

    /// Returns the names of the people, each once, in order.
    #[must_use]
    pub fn subjects(&self) -> Vec<String> {
        match &self.origin {
            ItemOrigin::Design { design, people } => {
                let (seed, sex) = (design.settings.seed, design.population.sex);
                let name = |number| cohort::name_of(seed, number, sex);
                people.clone().map(name).collect()
            }
            ItemOrigin::Pack { subjects, .. } => subjects.clone(),
        }
    }

    /// Returns the index in [`Self::subjects`] of an item's person.
    #[must_use]
    pub fn label(&self, item: usize) -> usize {
        let place = self.place(item);
        match &self.origin {
            ItemOrigin::Design { .. } => place.person,
            ItemOrigin::Pack { items, labels, .. } => {
                labels[place.cycle / items.variations.len() % labels.len()]
            }
        }
    }

    /// Returns the numbers of the people that must be made for these items, each once; none for a
    /// pack.
    #[must_use]
    pub fn people_of(&self, items: &[usize]) -> Vec<usize> {
        if let ItemOrigin::Pack { .. } = self.origin {
            return Vec::new();
        }
        let mut people: Vec<usize> = items.iter().map(|&item| self.place(item).person).collect();
        people.sort_unstable();
        people.dedup();
        people
    }

    /// Makes a person with all walks: a pack of 3 kB for one walk and 9 kB for ten, in 8 ms per
    /// walk.
    ///
    /// # Errors
    /// As [`Design::subject`] and [`encode_population`].
    pub fn make(&self, person: usize) -> Result<PackBytes> {
        match &self.origin {
            ItemOrigin::Pack { items, .. } => Ok(items.bytes.clone()),
            ItemOrigin::Design { design, people } => {
                let make = |_| design.subject(people.start + person);
                Ok(encode_population(0..1, &make, MAX_ERROR_MM, Effort::Quick, &|| Ok(()))?.into())
            }
        }
    }

    /// Draws the items of these numbers, in their order, from the packs of their [`people_of`].
    /// The calling thread draws a single item; more are drawn on the threads of the current pool.
    /// `drawers`, empty at first, are kept for the next call: one a thread, of at most 8 MB each.
    /// Pass 0 equals a stored dataset. Each further pass has other variations of the same walks,
    /// and the same uncut motions, which have no variations.
    /// `tell` is called before each cycle; an error from it ends the work.
    ///
    /// [`people_of`]: Self::people_of
    ///
    /// # Errors
    /// If an item cannot be drawn, the results exceed 2 GiB, `tell` fails, or there are no more
    /// passes.
    pub fn draw(
        &self,
        items: &[usize],
        pass: u32,
        packs: &BTreeMap<usize, PackBytes>,
        drawers: &mut Vec<Drawer>,
        tell: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<DrawnItems> {
        let shift = self.shift(pass)?;
        let shelf = self.shelf(packs)?;
        let arrays = self.arrays();
        let mut drawn = DrawnItems::new(&arrays, self.frames(items, shift, &shelf)?);
        // The calling thread draws a single item, without a pool.
        let threads = match items.len() {
            0 | 1 => 1,
            _ => rayon::current_num_threads(),
        };
        let mut places = drawn.places(&arrays);
        let with_places = |share: Vec<usize>| {
            let own = share.iter().map(|&at| std::mem::take(&mut places[at]));
            (own.collect(), share)
        };
        let shares = shares::divide(items, self.views(), threads).into_iter();
        let mut shares: Vec<(Vec<ItemBytes<'_>>, Vec<usize>)> = shares.map(with_places).collect();
        let spare = Mutex::new(std::mem::take(drawers));
        let paint = |(places, share): &mut (Vec<ItemBytes<'_>>, Vec<usize>)| {
            let known = spare.lock().expect("nobody panics here").pop();
            let mut drawer = match known {
                Some(drawer) => drawer,
                None => Drawer::new(self.settings, &self.wanted)?,
            };
            let mut places = places.as_mut_slice();
            for cycle in share.chunk_by(|&a, &b| items[a] / self.views() == items[b] / self.views())
            {
                tell()?;
                let (own, others) = std::mem::take(&mut places).split_at_mut(cycle.len());
                ItemBytes::fill(own, &self.cycle(&mut drawer, &shelf, items, cycle, shift)?)?;
                places = others;
            }
            spare.lock().expect("nobody panics here").push(drawer);
            Ok(())
        };
        let done: Vec<Result<()>> = match &mut shares[..] {
            [share] => vec![paint(share)],
            shares => shares.par_iter_mut().map(paint).collect(),
        };
        *drawers = spare.into_inner().expect("nobody panics here");
        // The first error, whichever thread ended first.
        done.into_iter().collect::<Result<()>>()?;
        Ok(drawn)
    }

    /// Returns the number of frames of each item, if all fit into the memory limit of one call.
    fn frames(&self, items: &[usize], shift: u32, shelf: &Shelf<'_>) -> Result<Vec<u32>> {
        let fixed = self.bytes(0);
        let of_frame = self.bytes(1) - fixed;
        let mut bytes = 0;
        let mut all = Vec::with_capacity(items.len());
        for cycle in items.chunk_by(|&a, &b| a / self.views() == b / self.views()) {
            let (pack, job) = self.job(shelf, self.place(cycle[0]))?;
            let job = job_in(pack, job, shift);
            let frames = self.wanted.frames(pack, job, &self.settings)?;
            bytes += cycle.len() * (fixed + frames as usize * of_frame);
            all.resize(all.len() + cycle.len(), frames);
        }
        if bytes > MAX_BYTES {
            return Err(ChoiceError::TooMuchAtOnce {
                items: items.len(),
                bytes,
                most: MAX_BYTES,
            }
            .into());
        }
        Ok(all)
    }

    /// Returns the index rows of these items.
    ///
    /// # Errors
    /// If there are no more passes.
    pub fn rows(
        &self,
        items: &[usize],
        pass: u32,
        packs: &BTreeMap<usize, PackBytes>,
    ) -> Result<Vec<IndexRow>> {
        let shift = self.shift(pass)?;
        let shelf = self.shelf(packs)?;
        let mut rows = Vec::with_capacity(items.len());
        for cycle in items.chunk_by(|&a, &b| a / self.views() == b / self.views()) {
            let Some(&first) = cycle.first() else {
                continue;
            };
            let (pack, job) = self.job(&shelf, self.place(first))?;
            let shifted = job_in(pack, job, shift);
            let frames = self.wanted.frames(pack, shifted, &self.settings)?;
            let mut row = IndexRow::of_job(pack, shifted, self.settings.seed, frames)?;
            if let ItemOrigin::Design { design, .. } = &self.origin
                && let Some(take) = design.take_of(job)
            {
                take.clone_into(&mut row.walk);
            }
            let views = self.views_of(pack, shifted)?;
            rows.extend(
                cycle
                    .iter()
                    .map(|item| row.seen_from(&views[item % views.len()])),
            );
        }
        Ok(rows)
    }

    /// Returns the order of the items in a stream. The items of `people_at_once` people are
    /// shuffled together; those of a cycle stay together if `is_by_cycle`.
    #[must_use]
    pub fn order(&self, seed: u64, people_at_once: usize, is_by_cycle: bool) -> ItemOrder {
        ItemOrder {
            seed,
            people: self.people() as u64,
            items: (self.cycles() * self.views()) as u64,
            at_once: people_at_once.max(1) as u64,
            together: if is_by_cycle { self.views() as u64 } else { 1 },
        }
    }

    /// Returns the person and cycle of an item.
    fn place(&self, item: usize) -> ItemCycle {
        let (views, cycles) = (self.views(), self.cycles());
        ItemCycle {
            person: item / views / cycles,
            cycle: item / views % cycles,
        }
    }

    /// Returns the shift of a pass's variation numbers.
    fn shift(&self, pass: u32) -> Result<u32> {
        let Some(before) = pass.checked_sub(1) else {
            return Ok(0);
        };
        let take = CYCLES_OF_A_TAKE;
        let Range { start, end } = match &self.origin {
            ItemOrigin::Design { design, .. } => 0..design.takes.len() as u32 * take,
            ItemOrigin::Pack { items, .. } => items.variations.clone(),
        };
        // Whole takes, so that no two passes share one; all numbers must fit in u32.
        let span = (end - start / take * take).checked_next_multiple_of(take);
        let shift = span
            .and_then(|span| FIRST_OF_PASSES.checked_add(before.checked_mul(span)?))
            .filter(|shift| shift.checked_add(end).is_some());
        shift.ok_or_else(|| ChoiceError::NoMorePasses(pass).into())
    }

    /// Opens the packs by person.
    fn shelf<'p>(&'p self, packs: &'p BTreeMap<usize, PackBytes>) -> Result<Shelf<'p>> {
        match &self.origin {
            ItemOrigin::Pack { items, .. } => {
                Ok(BTreeMap::from([(0, Pack::reopen(&items.bytes)?)]))
            }
            ItemOrigin::Design { .. } => {
                let opened = packs.iter().map(|(&person, bytes)| {
                    let pack = Pack::reopen(bytes)?;
                    Ok((person, pack))
                });
                opened.collect()
            }
        }
    }

    /// Returns the pack and the job of a person and cycle.
    fn job<'s>(
        &'s self,
        shelf: &'s Shelf<'s>,
        place: ItemCycle,
    ) -> Result<(&'s Pack<'s>, Job<'s>)> {
        let job = match &self.origin {
            ItemOrigin::Design { design, .. } => design.job(place.cycle),
            ItemOrigin::Pack { items, .. } => {
                let cycles = items.variations.len();
                let (walk, cycle) = (place.cycle / cycles, place.cycle % cycles);
                let (condition, walk) = (walk / items.walks.len(), walk % items.walks.len());
                Some(Job {
                    walk: items.walks[walk],
                    variation: items.variations.start + cycle as u32,
                    condition: items.conditions.get(condition),
                })
            }
        };
        let found = shelf.get(&place.person).zip(job);
        found.ok_or(Error::Missing("the person of an item"))
    }

    /// Returns the viewpoints of a job.
    fn views_of(&self, pack: &Pack<'_>, job: Job<'_>) -> Result<Cow<'_, [View]>> {
        match &self.origin {
            ItemOrigin::Design { design, .. } => design.views_of(pack, job).map(Cow::Owned),
            ItemOrigin::Pack { items, .. } => Ok(Cow::Borrowed(&items.views)),
        }
    }

    /// Draws one cycle from the views of these items.
    fn cycle(
        &self,
        drawer: &mut Drawer,
        shelf: &Shelf<'_>,
        items: &[usize],
        cycle: &[usize],
        shift: u32,
    ) -> Result<Swept> {
        let (pack, job) = self.job(shelf, self.place(items[cycle[0]]))?;
        let job = job_in(pack, job, shift);
        let all = self.views_of(pack, job)?;
        let of = |&at: &usize| all[items[at] % all.len()];
        let views: Vec<View> = cycle.iter().map(of).collect();
        drawer.draw(pack, job, &views)
    }
}

/// The opened packs by person.
type Shelf<'p> = BTreeMap<usize, Pack<'p>>;

/// Returns a job with its variation shifted. Uncut motions have no variations and stay the same.
fn job_in<'c>(pack: &Pack<'_>, job: Job<'c>, shift: u32) -> Job<'c> {
    let shift = if is_uncut(pack, job.walk) { 0 } else { shift };
    Job {
        variation: job.variation + shift,
        ..job
    }
}

#[cfg(test)]
mod tests;
