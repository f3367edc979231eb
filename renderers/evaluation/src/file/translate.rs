//! Whether a renderer's target has what neutral settings ask for.

use ltsc_core::capability::{Feature, Support, algorithm, sampler_feature};
use ltsc_core::diag::Span;
use ltsc_core::ir::{Filter, Integrator, Sampler};

use super::model::{Renderer, Variant};
use super::resolve::Findings;

/// Says what cannot be translated.
pub(super) fn check(variant: &Variant, renderer: &Renderer, findings: &mut Findings) {
    let settings = &variant.settings;
    // Where the algorithm is the scene's, it is not known here; its emission says the rest.
    let word = settings.integrator.map(|integrator| integrator.value);
    let integrator = word.and_then(|word| Integrator::of_word(word, 1)).unwrap_or(Integrator::Path { max_depth: 1 });
    let mut asked: Vec<(Feature, Span)> = Vec::new();
    if let Some(own) = &settings.integrator {
        asked.push((algorithm(&integrator).0, own.span));
    }
    if let Some(own) = &settings.sampler
        && let Some(sampler) = Sampler::of_word(own.value, 1, 0)
    {
        asked.push((sampler_feature(&sampler, &integrator), own.span));
    }
    if let Some(filter) = &settings.filter {
        let feature = match &filter.value {
            Filter::Box { radius: 0.5 } => Feature::PixelFilter,
            Filter::Box { radius: _ } => Feature::BoxFilter,
            Filter::Gaussian { stddev: _, radius: _ } => Feature::GaussianFilter,
        };
        asked.push((feature, filter.span));
    }
    for (feature, span) in asked {
        if let Support::Unsupported { why } = (renderer.target.supports)(feature) {
            let message = format!("`{}` has no {}: {why}", renderer.target.name, feature.name());
            findings.error("evaluation-setting", span, message).help = Some(format!(
                "leave `{}` out of the case, or say something else under `for.{}`",
                renderer.name,
                bare(&renderer.name)
            ));
        }
    }
}

fn bare(name: &str) -> String {
    super::print::key(name)
}
