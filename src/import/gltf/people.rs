//! The people of a glTF file: skins whose joints do not hang together.

use gltf::{Document, Skin};

use super::NodeGraph;

/// The minimum number of joints of a person; fewer are a prop or a garment. Our choice: legs, arms
/// and a trunk have more.
const LEAST_JOINTS: usize = 10;

/// Skins whose joints are below each other.
struct Group<'a> {
    skins: Vec<Skin<'a>>,
    /// The path from the top of the scene to the node above all of its joints.
    path: Vec<usize>,
}

impl Group<'_> {
    fn is_person(&self) -> bool {
        let joints = self.skins.iter().map(|skin| skin.joints().count());
        joints.max().unwrap_or(0) >= LEAST_JOINTS
    }
}

/// Returns the skins of a person: of the named one, or else of the only one.
///
/// # Errors
/// A sentence with the names, if there are several people and none is named, or nobody is called so.
pub(super) fn chosen<'a>(
    document: &Document,
    graph: &NodeGraph,
    skins: Vec<Skin<'a>>,
    person: Option<&str>,
) -> Result<Vec<Skin<'a>>, String> {
    let mut groups = groups(graph, &skins);
    groups.retain(Group::is_person);
    if groups.len() < 2 && person.is_none() {
        return Ok(skins);
    }
    let names = names(document, &groups);
    let known = || match names.as_slice() {
        [] => "nobody has a skin of 10 joints or more".to_owned(),
        names => format!("there are: {}", names.join(", ")),
    };
    let Some(person) = person else {
        return Err(format!(
            "several people, expected the name of one; {}",
            known()
        ));
    };
    let mut found = (names.iter().zip(groups)).filter(|(name, _)| *name == person);
    match (found.next(), found.next()) {
        (Some((_, group)), None) => Ok(group.skins),
        (Some(_), Some(_)) => Err(format!(
            "several people are called {person}: rename their nodes"
        )),
        (None, _) => Err(format!("no person {person}; {}", known())),
    }
}

/// Groups skins of which one's joints are below another's. A skin without a node above all of its
/// joints is in no group.
fn groups<'a>(graph: &NodeGraph, skins: &[Skin<'a>]) -> Vec<Group<'a>> {
    let mut groups: Vec<Group<'a>> = Vec::new();
    for skin in skins {
        let Some(path) = path_above(graph, skin) else {
            continue;
        };
        let mut joined = Group {
            skins: vec![skin.clone()],
            path,
        };
        let (below, apart) = groups.into_iter().partition(|group| {
            joined.path.starts_with(&group.path) || group.path.starts_with(&joined.path)
        });
        groups = apart;
        let below: Vec<Group<'a>> = below;
        for group in below {
            joined.skins.extend(group.skins);
            if group.path.len() < joined.path.len() {
                joined.path = group.path;
            }
        }
        groups.push(joined);
    }
    groups
}

/// Returns the path from the top of the scene to the lowest node above all joints of a skin.
fn path_above(graph: &NodeGraph, skin: &Skin) -> Option<Vec<usize>> {
    let paths = skin.joints().map(|joint| {
        let mut path = graph.path_to_top(joint.index());
        path.reverse();
        path
    });
    let common = paths.reduce(|mut known, path| {
        let same = known.iter().zip(&path).take_while(|(a, b)| a == b).count();
        known.truncate(same);
        known
    });
    common.filter(|path| !path.is_empty())
}

/// Returns the groups' names: of the highest nodes that are not above several groups.
fn names(document: &Document, groups: &[Group]) -> Vec<String> {
    let paths: Vec<&Vec<usize>> = groups.iter().map(|group| &group.path).collect();
    let shared = match paths.as_slice() {
        [first, others @ ..] if !others.is_empty() => {
            let same = |path: &&Vec<usize>| {
                let pairs = first.iter().zip(*path);
                pairs.take_while(|(a, b)| a == b).count()
            };
            others.iter().map(same).min().unwrap_or(0)
        }
        _ => 0,
    };
    let own = paths.iter().map(|path| path.get(shared).or(path.last()));
    own.flatten()
        .map(|&node| {
            let name = document.nodes().nth(node).and_then(|node| node.name());
            name.map_or_else(|| format!("node {node}"), str::to_owned)
        })
        .collect()
}
