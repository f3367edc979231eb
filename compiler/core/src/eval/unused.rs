//! Names that a file declares and never uses.

use std::collections::BTreeSet;

use crate::syntax::{Expr, ExprKind, Kind, Name, Statement, StatementKind};

/// What statements name and what they declare, gathered while they are read.
///
/// A name that is used in one place and declared in two scopes counts as used in both.
#[derive(Default)]
pub(super) struct Looked {
    used: BTreeSet<String>,
    /// Word, name, and whether the declaration stands at the top of the file, where a library declares for others.
    declared: Vec<(&'static str, Name, bool)>,
}

impl Looked {
    /// The values and functions that nothing names, in the order of the text. What a library declares at its top is for
    /// others and not among them, unless `scene` is said.
    pub(super) fn unused(self, scene: bool) -> impl Iterator<Item = (&'static str, Name)> {
        let Self { used, declared } = self;
        let vain = move |(_, name, exported): &(_, Name, bool)| (scene || !exported) && !used.contains(&name.text);
        declared.into_iter().filter(vain).map(|(kind, name, _)| (kind, name))
    }

    /// Looks at the next statements of a file.
    pub(super) fn statement(&mut self, statement: &Statement) {
        self.statements(std::slice::from_ref(statement), true);
    }

    fn statements(&mut self, statements: &[Statement], top: bool) {
        for statement in statements {
            match &statement.kind {
                StatementKind::Declaration {
                    kind: kind @ (Kind::Let | Kind::Material | Kind::Mesh | Kind::Texture | Kind::Group),
                    name: Some(name),
                    ..
                } => self.declared.push((kind.word(), name.clone(), top)),
                StatementKind::Group { name, .. } => self.declared.push((Kind::Group.word(), name.clone(), top)),
                StatementKind::Use { names, .. } => {
                    let local =
                        names.iter().map(|(name, alias)| ("use", alias.as_ref().unwrap_or(name).clone(), false));
                    self.declared.extend(local);
                }
                StatementKind::Parameter { name, .. } => self.declared.push(("param", name.clone(), false)),
                StatementKind::Declaration { .. }
                | StatementKind::Version(_)
                | StatementKind::Scene { .. }
                | StatementKind::For { .. }
                | StatementKind::If { .. }
                | StatementKind::Allow { .. } => {}
            }
            let mut bodies = Vec::new();
            statement.each_part(&mut |expr| self.expr(expr), &mut |body| bodies.push(body));
            bodies.into_iter().for_each(|body| self.statements(body, false));
        }
    }

    fn expr(&mut self, expr: &Expr) {
        let name = match &expr.kind {
            ExprKind::Name(name) => Some(name),
            ExprKind::Call(call) => Some(&call.name.text),
            _ => None,
        };
        if let Some(name) = name.filter(|name| !self.used.contains(*name)) {
            self.used.insert(name.clone());
        }
        expr.each_part(&mut |part| self.expr(part));
    }
}
