//! Still pairs.

use std::path::Path;

use limpid::Result;
use limpid::offline::eval::pairs::{PairList, evaluate_pairs};

use super::{EvalArguments, shown};

pub(super) fn execute(arguments: &EvalArguments, list: &Path, folder: &Path) -> Result<()> {
    let list = PairList::read(list)?;
    let config = arguments.config()?;
    let adapter = arguments.adapter.as_deref();
    let shown = shown::draw_all(arguments)?;
    let mut report = evaluate_pairs(folder, &list, &config, adapter, arguments.html.as_deref())?;
    report.pictures.extend(shown);
    let table = report.table();
    println!("{}: {}\n{}", table.title, table.note, table.text());
    arguments.write(&report.json(), &report.html())
}
