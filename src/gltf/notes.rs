use std::collections::HashSet;

/// What the user should know about an import that went well; each sentence once.
#[derive(Debug, Default)]
pub(super) struct Notes {
    list: Vec<String>,
    seen: HashSet<String>,
}

impl Notes {
    /// Adds a sentence, unless it is there already.
    pub(super) fn add(&mut self, note: String) {
        if self.seen.insert(note.clone()) {
            self.list.push(note);
        }
    }

    /// The sentences in the order they came.
    pub(super) fn into_list(self) -> Vec<String> {
        self.list
    }
}
