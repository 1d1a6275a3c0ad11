//! How do slices get out of structs? A kernel's struct of slices reaches SPIR-V as a struct of pointers, which logical addressing
//! does not allow: some validators let it pass, and NVIDIA's compiler crashes on it.
#![cfg_attr(not(feature = "shaders"), allow(dead_code))]

use crate::spirv::{HEADER, OP_DECORATE, instructions};
use std::collections::{HashMap, HashSet};

const OP_UNDEF: u32 = 1;
const OP_TYPE_STRUCT: u32 = 30;
const OP_TYPE_POINTER: u32 = 32;
const OP_MEMBER_DECORATE: u32 = 72;
const OP_CONSTRUCT: u32 = 80;
const OP_EXTRACT: u32 = 81;
const OP_INSERT: u32 = 82;
const OP_COPY_OBJECT: u32 = 83;
/// FunctionCall, Variable, Load, Store, Select, Phi, ReturnValue: what may not handle such structs. All their operands that are not
/// the type are ids, but for a variable's storage class.
const CARRIERS: [u32; 7] = [57, 59, 61, 62, 169, 245, 254];

/// The types of structs that hold pointers, or structs that do.
fn types_with_pointers(words: &[u32]) -> Result<HashSet<u32>, String> {
    let list = instructions(words)?;
    let pointers: HashSet<u32> =
        list.iter().filter(|(_, op, _)| *op == OP_TYPE_POINTER).map(|&(at, ..)| words[at + 1]).collect();
    let mut found = HashSet::new();
    loop {
        let before = found.len();
        for &(at, op, count) in &list {
            let members = &words[at + 2.min(count)..at + count];
            if op == OP_TYPE_STRUCT && members.iter().any(|m| pointers.contains(m) || found.contains(m)) {
                found.insert(words[at + 1]);
            }
        }
        if found.len() == before {
            return Ok(found);
        }
    }
}

/// How many types of structs hold pointers.
pub fn structs_of_pointers(words: &[u32]) -> Result<usize, String> {
    Ok(types_with_pointers(words)?.len())
}

/// What makes up a struct.
enum Made<'a> {
    Insert { object: u32, composite: u32, path: &'a [u32] },
    Construct { parts: &'a [u32] },
    Extract { composite: u32, path: &'a [u32] },
}

/// Follows a path into a struct to what was put there; what is left of the path, if it ends early.
fn follow(made: &HashMap<u32, Made<'_>>, id: u32, path: &[u32]) -> (u32, Vec<u32>) {
    let (mut id, mut path) = (id, path.to_vec());
    loop {
        match made.get(&id) {
            Some(Made::Extract { composite, path: before }) => {
                path.splice(0..0, before.iter().copied());
                id = *composite;
            }
            Some(Made::Construct { parts }) if !path.is_empty() => {
                id = parts[path.remove(0) as usize];
            }
            Some(Made::Insert { object, composite, path: own }) => {
                if path.starts_with(own) {
                    path.drain(..own.len());
                    id = *object;
                } else if own.starts_with(&path) {
                    return (id, path);
                } else {
                    id = *composite;
                }
            }
            _ => return (id, path),
        }
    }
}

/// Replaces what is taken out of structs of pointers by what was put in, and removes these structs.
///
/// # Errors
/// Structs of pointers that are stored, chosen or passed on: the kernel has to be written otherwise.
pub fn dissolve(words: &[u32]) -> Result<Vec<u32>, String> {
    let types = types_with_pointers(words)?;
    let list = instructions(words)?;
    let mut made = HashMap::new();
    let mut values = HashSet::new();
    for &(at, op, count) in &list {
        let operands = &words[at + 1..at + count];
        if !matches!(op, OP_UNDEF | OP_CONSTRUCT | OP_EXTRACT | OP_INSERT) || !types.contains(&operands[0]) {
            continue;
        }
        values.insert(operands[1]);
        let how = match op {
            OP_INSERT => Made::Insert { object: operands[2], composite: operands[3], path: &operands[4..] },
            OP_CONSTRUCT => Made::Construct { parts: &operands[2..] },
            OP_EXTRACT => Made::Extract { composite: operands[2], path: &operands[3..] },
            _ => continue,
        };
        made.insert(operands[1], how);
    }
    let mut out = words[..HEADER].to_vec();
    for &(at, op, count) in &list {
        let all = &words[at..at + count];
        let typed = count > 2 && types.contains(&all[1]);
        match op {
            OP_TYPE_STRUCT | OP_DECORATE | OP_MEMBER_DECORATE if types.contains(&all[1]) => {}
            OP_TYPE_POINTER if types.contains(&all[3]) => {}
            OP_UNDEF | OP_CONSTRUCT | OP_INSERT | OP_EXTRACT if typed => {}
            OP_EXTRACT if values.contains(&all[3]) => {
                let (id, path) = follow(&made, all[3], &all[4..]);
                if values.contains(&id) {
                    return Err(format!("value {} of a struct of pointers is not known", all[2]));
                }
                let (op, count) =
                    if path.is_empty() { (OP_COPY_OBJECT, 4) } else { (OP_EXTRACT, 4 + path.len()) };
                out.extend([(count as u32) << 16 | op, all[1], all[2], id]);
                out.extend(path);
            }
            _ if CARRIERS.contains(&op) && (typed || all[1..].iter().any(|w| values.contains(w))) => {
                return Err(format!("operation {op} carries a struct of pointers"));
            }
            _ => out.extend(all),
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ids 1 uint, 2 pointer, 3 struct {2, 1}, 4 struct {3, 1}; 10 is a pointer, 11 and 12 numbers.
    fn sample(taken: &[u32]) -> Vec<u32> {
        let mut words = vec![0x0723_0203, 0x0001_0500, 0, 100, 0];
        let mut put = |op: u32, operands: &[u32]| {
            words.push(((operands.len() as u32 + 1) << 16) | op);
            words.extend(operands);
        };
        put(OP_MEMBER_DECORATE, &[3, 1, 35, 0]);
        put(21, &[1, 32, 0]);
        put(OP_TYPE_POINTER, &[2, 12, 1]);
        put(OP_TYPE_STRUCT, &[3, 2, 1]);
        put(OP_TYPE_STRUCT, &[4, 3, 1]);
        put(OP_UNDEF, &[4, 13]);
        put(OP_INSERT, &[4, 14, 10, 13, 0, 0]);
        put(OP_INSERT, &[4, 15, 11, 14, 0, 1]);
        put(OP_INSERT, &[4, 16, 12, 15, 1]);
        put(OP_EXTRACT, &[3, 17, 16, 0]);
        put(OP_EXTRACT, taken);
        words
    }

    #[test]
    fn what_is_taken_out_is_what_was_put_in() {
        for (taken, right) in [
            (&[2, 20, 17, 0][..], [(4 << 16) | OP_COPY_OBJECT, 2, 20, 10]),
            (&[1, 20, 17, 1], [(4 << 16) | OP_COPY_OBJECT, 1, 20, 11]),
            (&[1, 20, 16, 1], [(4 << 16) | OP_COPY_OBJECT, 1, 20, 12]),
            (&[1, 20, 16, 0, 1], [(4 << 16) | OP_COPY_OBJECT, 1, 20, 11]),
        ] {
            let words = sample(taken);
            assert_eq!(structs_of_pointers(&words), Ok(2));
            let got = dissolve(&words).unwrap();
            assert_eq!(structs_of_pointers(&got), Ok(0));
            assert!(got.ends_with(&right), "{got:?}");
            assert_eq!(dissolve(&got).unwrap(), got);
        }
    }

    #[test]
    fn what_cannot_be_known_is_refused() {
        let mut words = sample(&[1, 20, 16, 1]);
        words.extend([(7 << 16) | 245, 4, 30, 16, 40, 15, 41]);
        assert!(dissolve(&words).unwrap_err().contains("245"));
        let mut from_undef = sample(&[1, 20, 13, 1]);
        assert!(dissolve(&from_undef).unwrap_err().contains("not known"));
        from_undef.pop();
        assert!(dissolve(&from_undef).is_err());
    }
}
