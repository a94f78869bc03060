//! Cached answers: a slow network computes the answer to each input once.
//!
//! Each model, contract and runtime has a file, to which answers are appended as they come. So an
//! interrupted run leaves its answers to the next run, whatever that run's protocol, conditions or
//! source. Answers are found by the hash of the input's bytes. The last bits of an answer can
//! depend on the rest of its batch, as far as the runtime allows; the first computed answer is
//! kept.

use super::provider::RuntimeName;
use super::{Contract, Model, Outputs, Recognizer, join};
use crate::error::{Error, Result};
use crate::files::cache::{Cache, CacheKey, touch};
use sha2::{Digest as _, Sha256};
use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// The fewest multiply-accumulates of an input that are worth caching. Our choice: 100 us, ten
/// times as long as a lookup takes.
const LEAST_MACS: u64 = 1_000_000;
/// The maximum size of a file, bytes: further answers are not kept.
const MOST_BYTES: u64 = 1 << 29;
const KIND: &str = "answers";

/// Bytes before an answer's numbers: the input's hash, and the counts of embedding numbers, parts
/// and scores.
const HEAD: usize = HASH + 3 * 4;
/// Bytes of the input's hash.
const HASH: usize = 16;
/// Bytes after the numbers: the start of the hash of all that precedes.
const CHECK: usize = 8;

type Hash = [u8; HASH];

/// A recognizer that caches its answers.
pub struct CachedRecognizer {
    recognizer: Box<dyn Recognizer>,
    file: Mutex<AnswerFile>,
}

/// A file of answers.
struct AnswerFile {
    file: File,
    /// The offset of each answer.
    known: HashMap<Hash, u64>,
    end: u64,
    /// Whether this process may append; only one at a time may.
    is_own: bool,
    /// The model's own counts, once it has answered: another answer is none.
    counts: Option<[usize; 3]>,
}

/// The answer to one input.
struct CachedAnswer {
    embedding: Vec<f32>,
    parts: usize,
    scores: Vec<f32>,
}

impl CachedRecognizer {
    /// Returns a caching recognizer if the cache is on and the model is slow enough, else the
    /// recognizer itself.
    ///
    /// # Errors
    /// If the system cannot read the file of answers.
    pub fn wrap(
        recognizer: Box<dyn Recognizer>,
        model: &Model,
        cache: &Cache,
    ) -> Result<Box<dyn Recognizer>> {
        // A model that cannot be counted may be slow.
        let macs = model.macs().unwrap_or(LEAST_MACS);
        let stated = format!("{:?} {:?}", recognizer.contract(), recognizer.runtime());
        let key = CacheKey::hash(&[model.bytes(), stated.as_bytes()]);
        let path = cache.path(KIND, &key).filter(|_| macs >= LEAST_MACS);
        Ok(match path {
            None => recognizer,
            Some(path) => {
                let file = Mutex::new(AnswerFile::open(&path)?);
                cache.make_room()?;
                Box::new(Self { recognizer, file })
            }
        })
    }
}

impl Recognizer for CachedRecognizer {
    fn runtime(&self) -> &RuntimeName {
        self.recognizer.runtime()
    }

    fn contract(&self) -> &Contract {
        self.recognizer.contract()
    }

    fn at_once(&self) -> usize {
        self.recognizer.at_once()
    }

    fn run(&self, input: &[f32], batch: usize) -> Result<Outputs> {
        let each = input.len().checked_div(batch).unwrap_or(0).max(1);
        let inputs: Vec<&[f32]> = input.chunks_exact(each).collect();
        if inputs.len() != batch {
            // It reports what is wrong.
            return self.recognizer.run(input, batch);
        }
        let hashes: Vec<Hash> = inputs.iter().map(|input| hash(input)).collect();
        // Never held while the recognizer runs: other threads may ask it.
        let file = || self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let mut answers: Vec<Option<CachedAnswer>> = (0..batch).map(|_| None).collect();
        // At most twice: an answer in the file may be broken, or not be this model's.
        while answers.iter().any(Option::is_none) {
            let is_lacking = |&at: &usize| answers[at].is_none() && !file().has(&hashes[at]);
            let lacking: Vec<usize> = (0..batch).filter(is_lacking).collect();
            let are_counts_known = file().counts.is_some();
            if !lacking.is_empty() {
                let asked: Vec<f32> = lacking.iter().flat_map(|&at| inputs[at]).copied().collect();
                let found = self.recognizer.run(&asked, lacking.len())?;
                let mut file = file();
                file.counts = Some(counts_of(&found));
                for (row, &at) in lacking.iter().enumerate() {
                    let answer = CachedAnswer::from_row(&found, row);
                    file.add(&hashes[at], &answer);
                    answers[at] = Some(answer);
                }
            } else if !are_counts_known {
                let found = self.recognizer.run(inputs[0], 1)?;
                file().counts = Some(counts_of(&found));
            }
            let mut file = file();
            for (answer, hash) in answers.iter_mut().zip(&hashes) {
                if answer.is_none() {
                    *answer = file.find(hash);
                }
            }
        }
        let mut outputs = Outputs::default();
        for answer in answers.into_iter().flatten() {
            outputs.embedding_dims = answer.embedding.len();
            outputs.embedding_parts = answer.parts;
            outputs.classes = answer.scores.len();
            let numbers = answer.embedding.iter().chain(&answer.scores);
            outputs.non_finite += numbers.filter(|number| !number.is_finite()).count();
            if !answer.scores.is_empty() {
                join(outputs.scores.get_or_insert_default(), answer.scores);
            }
            join(&mut outputs.embedding, answer.embedding);
        }
        Ok(outputs)
    }

    fn behind(&self) -> Option<&dyn Recognizer> {
        Some(self.recognizer.as_ref())
    }

    fn beside(&self, work: &mut (dyn FnMut() + Send)) {
        self.recognizer.beside(work);
    }
}

impl CachedAnswer {
    /// Returns the answer to one input of a batch.
    fn from_row(outputs: &Outputs, row: usize) -> Self {
        let part = |numbers: &[f32], width: usize| {
            let numbers = numbers.get(row * width..(row + 1) * width);
            numbers.unwrap_or_default().to_vec()
        };
        Self {
            embedding: part(&outputs.embedding, outputs.embedding_dims),
            parts: outputs.embedding_parts,
            scores: part(
                outputs.scores.as_deref().unwrap_or_default(),
                outputs.classes,
            ),
        }
    }
}

impl AnswerFile {
    fn open(path: &Path) -> Result<Self> {
        let io = |error| Error::io(path, error);
        let folder = path.parent().unwrap_or(path);
        fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
        let mut options = File::options();
        let options = options.read(true).write(true).create(true).truncate(false);
        let file = options.open(path).map_err(io)?;
        touch(path);
        let mut answered = Self {
            known: HashMap::new(),
            end: 0,
            is_own: file.try_lock().is_ok(),
            counts: None,
            file,
        };
        let length = answered.file.metadata().map_err(io)?.len();
        let mut head = [0; HEAD];
        while answered.end + (HEAD + CHECK) as u64 <= length {
            let begin = answered.end;
            if answered.read_at(begin, &mut head).is_none() {
                break;
            }
            let Some(numbers) = numbers_after(&head) else {
                break;
            };
            let end = begin + (HEAD + 4 * numbers + CHECK) as u64;
            // Cut short when its process ended: the next answer overwrites it.
            if end > length {
                break;
            }
            let mut hash = Hash::default();
            hash.copy_from_slice(&head[..HASH]);
            answered.known.insert(hash, begin);
            answered.end = end;
        }
        if answered.is_own {
            answered.file.set_len(answered.end).map_err(io)?;
        }
        Ok(answered)
    }

    /// Reads bytes at an offset of the file.
    fn read_at(&mut self, begin: u64, bytes: &mut [u8]) -> Option<()> {
        self.file.seek(SeekFrom::Start(begin)).ok()?;
        self.file.read_exact(bytes).ok()
    }

    /// Returns whether the file has an answer to an input, as far as is known.
    fn has(&self, hash: &Hash) -> bool {
        self.known.contains_key(hash)
    }

    /// Returns the answer to an input, if it is in the file, intact and of the model's counts, and
    /// forgets it otherwise.
    fn find(&mut self, hash: &Hash) -> Option<CachedAnswer> {
        let found = self.intact(hash);
        if found.is_none() {
            self.known.remove(hash);
        }
        found
    }

    fn intact(&mut self, hash: &Hash) -> Option<CachedAnswer> {
        let begin = *self.known.get(hash)?;
        let mut head = [0; HEAD];
        self.read_at(begin, &mut head)?;
        let mut record = vec![0; HEAD + 4 * numbers_after(&head)? + CHECK];
        self.read_at(begin, &mut record)?;
        let (content, check) = record.split_last_chunk::<CHECK>()?;
        let is_intact = content.get(..HASH) == Some(hash) && check_of(content) == *check;
        if !is_intact || self.counts != Some(counts(&head)) {
            return None;
        }
        let [dims, parts, _] = counts(&head);
        let numbers = content[HEAD..].as_chunks::<4>().0;
        let numbers: Vec<f32> = numbers
            .iter()
            .map(|&bytes| f32::from_le_bytes(bytes))
            .collect();
        let (embedding, scores) = numbers.split_at_checked(dims)?;
        Some(CachedAnswer {
            embedding: embedding.to_vec(),
            parts,
            scores: scores.to_vec(),
        })
    }

    /// Appends an answer, if there is room. An answer that cannot be written is not kept.
    fn add(&mut self, hash: &Hash, answer: &CachedAnswer) {
        let mut record = hash.to_vec();
        for count in [answer.embedding.len(), answer.parts, answer.scores.len()] {
            let Ok(count) = u32::try_from(count) else {
                return;
            };
            record.extend(count.to_le_bytes());
        }
        for number in answer.embedding.iter().chain(&answer.scores) {
            record.extend(number.to_le_bytes());
        }
        record.extend(check_of(&record));
        let end = self.end + record.len() as u64;
        if !self.is_own || end > MOST_BYTES {
            return;
        }
        let placed = self.file.seek(SeekFrom::Start(self.end));
        if placed.and_then(|_| self.file.write_all(&record)).is_ok() {
            self.known.insert(*hash, self.end);
            self.end = end;
        }
    }
}

/// Returns the counts of each answer of a model.
const fn counts_of(outputs: &Outputs) -> [usize; 3] {
    [
        outputs.embedding_dims,
        outputs.embedding_parts,
        outputs.classes,
    ]
}

/// Returns the counts in an answer's head.
fn counts(head: &[u8; HEAD]) -> [usize; 3] {
    let mut counts = [0; 3];
    for (count, bytes) in counts.iter_mut().zip(head[HASH..].as_chunks::<4>().0) {
        *count = u32::from_le_bytes(*bytes) as usize;
    }
    counts
}

/// Returns how many numbers follow an answer's head, if the head is valid.
fn numbers_after(head: &[u8; HEAD]) -> Option<usize> {
    let [dims, parts, classes] = counts(head);
    let numbers = dims.checked_add(classes)?;
    (dims > 0 && parts > 0 && numbers <= 1 << 26).then_some(numbers)
}

/// Returns the hash by which an answer is found.
fn hash(input: &[f32]) -> Hash {
    let mut digest = Sha256::new();
    for numbers in input.chunks(1_024) {
        let bytes: Vec<u8> = numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect();
        digest.update(bytes);
    }
    let mut hash = Hash::default();
    hash.copy_from_slice(&digest.finalize()[..HASH]);
    hash
}

fn check_of(content: &[u8]) -> [u8; CHECK] {
    let mut check = [0; CHECK];
    check.copy_from_slice(&Sha256::digest(content)[..CHECK]);
    check
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A recognizer whose embedding is the sum of an input and its first number, and which counts
    /// the inputs it was given.
    struct Counting {
        asked: Arc<AtomicUsize>,
        contract: Contract,
        runtime: RuntimeName,
    }

    impl Recognizer for Counting {
        fn runtime(&self) -> &RuntimeName {
            &self.runtime
        }

        fn contract(&self) -> &Contract {
            &self.contract
        }

        fn run(&self, input: &[f32], batch: usize) -> Result<Outputs> {
            self.asked.fetch_add(batch, Ordering::Relaxed);
            let each = input.chunks_exact(input.len() / batch);
            Ok(Outputs {
                embedding: each
                    .clone()
                    .flat_map(|image| [image.iter().sum(), image[0]])
                    .collect(),
                embedding_dims: 2,
                embedding_parts: 1,
                scores: Some(each.map(|image| image[1]).collect()),
                classes: 1,
                non_finite: 0,
            })
        }
    }

    fn kept(path: &Path) -> (CachedRecognizer, Arc<AtomicUsize>) {
        let asked = Arc::new(AtomicUsize::new(0));
        let counting = Counting {
            asked: Arc::clone(&asked),
            contract: Contract::default(),
            runtime: RuntimeName::default(),
        };
        let file = Mutex::new(AnswerFile::open(path).unwrap());
        let recognizer = Box::new(counting);
        (CachedRecognizer { recognizer, file }, asked)
    }

    const INPUT: [f32; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, f32::NAN];

    #[test]
    fn what_was_answered_once_is_answered_the_same_by_the_next_process() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("answers/a");
        let (first, asked) = kept(&path);
        let two = first.run(&INPUT[..4], 2).unwrap();
        assert_eq!(two.embedding, [3.0, 1.0, 7.0, 3.0]);
        assert_eq!(two.scores.as_deref(), Some(&[2.0, 4.0][..]));
        drop(first);
        assert_eq!(asked.load(Ordering::Relaxed), 2);

        let (second, asked) = kept(&path);
        // One is new, and not finite.
        let three = second.run(&[&INPUT[2..], &INPUT[..2]].concat(), 3).unwrap();
        assert_eq!(asked.load(Ordering::Relaxed), 1);
        assert_eq!(three.embedding[..2], [7.0, 3.0]);
        assert!(three.embedding[2].is_nan());
        assert_eq!((three.embedding[4], three.non_finite), (3.0, 2));
        assert_eq!(
            (three.embedding_dims, three.embedding_parts, three.classes),
            (2, 1, 1)
        );
        second.run(&INPUT, 3).unwrap();
        assert_eq!(asked.load(Ordering::Relaxed), 1);
        assert!(second.behind().is_some());
    }

    #[test]
    fn what_is_cut_short_or_broken_is_asked_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let (first, _) = kept(&path);
        first.run(&INPUT[..4], 2).unwrap();
        drop(first);
        let whole = fs::read(&path).unwrap();
        let record = HEAD + 3 * 4 + CHECK;
        assert_eq!(whole.len(), 2 * record);
        for (length, lacking) in [
            // An answer tells the model's counts.
            (2 * record, 1),
            (2 * record - 1, 1),
            (record + 3, 1),
            (5, 2),
            (0, 2),
        ] {
            fs::write(&path, &whole[..length]).unwrap();
            let (again, asked) = kept(&path);
            let two = again.run(&INPUT[..4], 2).unwrap();
            assert_eq!(two.embedding, [3.0, 1.0, 7.0, 3.0]);
            assert_eq!(asked.load(Ordering::Relaxed), lacking, "{length}");
            drop(again);
            let mut found = fs::read(&path).unwrap();
            // The order differs if the second answer was kept and the first was not.
            found.sort_unstable();
            let mut expected = whole.clone();
            expected.sort_unstable();
            assert_eq!(found, expected);
        }
        // Any changed byte loses one answer or more, and gives no wrong one.
        for at in 0..whole.len() {
            let mut broken = whole.clone();
            broken[at] ^= 0x11;
            fs::write(&path, &broken).unwrap();
            let (again, asked) = kept(&path);
            let two = again.run(&INPUT[..4], 2).unwrap();
            assert_eq!(two.embedding, [3.0, 1.0, 7.0, 3.0], "{at}");
            assert!(asked.load(Ordering::Relaxed) >= 1, "{at}");
        }
    }

    #[test]
    fn an_answer_of_other_counts_than_the_models_is_asked_again() {
        let folder = tempfile::tempdir().unwrap();
        for (numbers, parts, scores) in [(3, 1, 1), (2, 2, 1), (2, 1, 0), (64, 7, 1)] {
            let path = folder.path().join(format!("{numbers} {parts} {scores}"));
            let answer = CachedAnswer {
                embedding: vec![9.0; numbers],
                parts,
                scores: vec![9.0; scores],
            };
            AnswerFile::open(&path)
                .unwrap()
                .add(&hash(&INPUT[..2]), &answer);
            let (again, asked) = kept(&path);
            let two = again.run(&INPUT[..4], 2).unwrap();
            assert_eq!(two.embedding, [3.0, 1.0, 7.0, 3.0]);
            assert_eq!(two.scores.as_deref(), Some(&[2.0, 4.0][..]));
            assert_eq!(asked.load(Ordering::Relaxed), 2);
            // Alone, once for the counts, and once for the answer.
            let (alone, asked) = kept(&path);
            alone.run(&INPUT[..2], 1).unwrap();
            assert!(asked.load(Ordering::Relaxed) <= 2);
        }
    }

    #[test]
    fn a_second_process_reads_and_does_not_write() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let (first, _) = kept(&path);
        first.run(&INPUT[..2], 1).unwrap();
        let (second, asked) = kept(&path);
        second.run(&INPUT[..4], 2).unwrap();
        assert_eq!(asked.load(Ordering::Relaxed), 1);
        drop(second);
        first.run(&INPUT[..4], 2).unwrap();
        drop(first);
        assert_eq!(fs::read(&path).unwrap().len(), 2 * (HEAD + 3 * 4 + CHECK));
    }
}
