//! Names that a file declares and never uses.

use std::collections::BTreeSet;

use crate::syntax::{Expr, ExprKind, Kind, Name, Statement, StatementKind};

/// The values and functions that nothing in `statements` names, in the order of the text. What a library declares at its top
/// is for others and not among them, unless `scene` is said.
///
/// A name that is used in one place and declared in two scopes counts as used in both.
pub(super) fn unused(statements: &[Statement], scene: bool) -> Vec<(&'static str, &Name)> {
    let mut looked = Looked::default();
    looked.statements(statements, !scene);
    let Looked { used, declared } = looked;
    declared.into_iter().filter(|(_, name)| !used.contains(name.text.as_str())).collect()
}

#[derive(Default)]
struct Looked<'t> {
    used: BTreeSet<&'t str>,
    declared: Vec<(&'static str, &'t Name)>,
}

impl<'t> Looked<'t> {
    fn statements(&mut self, statements: &'t [Statement], exported: bool) {
        for statement in statements {
            match &statement.kind {
                StatementKind::Declaration {
                    kind: kind @ (Kind::Let | Kind::Material | Kind::Mesh | Kind::Texture | Kind::Group),
                    name: Some(name),
                    ..
                } if !exported => self.declared.push((kind.word(), name)),
                StatementKind::Group { name, .. } if !exported => self.declared.push((Kind::Group.word(), name)),
                StatementKind::Use { names, .. } => {
                    let local = names.iter().map(|(name, alias)| ("use", alias.as_ref().unwrap_or(name)));
                    self.declared.extend(local);
                }
                StatementKind::Parameter { name, .. } => self.declared.push(("param", name)),
                StatementKind::Declaration { .. }
                | StatementKind::Group { .. }
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

    fn expr(&mut self, expr: &'t Expr) {
        match &expr.kind {
            ExprKind::Name(name) => {
                self.used.insert(name);
            }
            ExprKind::Call(call) => {
                self.used.insert(&call.name.text);
            }
            _ => {}
        }
        expr.each_part(&mut |part| self.expr(part));
    }
}
