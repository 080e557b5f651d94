#include "tools/score/page/worst_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/score/page/html_text.h"

namespace touchline::score::page {

namespace {

constexpr double kAsBad = 0.1;  // of the worst: nearly as bad, where that is shown anyway

}  // namespace

std::string WorstFrame::id() const {
  return fmt::format("{}-{}-{:06}", plain(group), plain(subject), frame);
}

double badness(const ScoreKind& kind, double value) {
  switch (kind.better) {
    case Better::kHigher:
      return (kind.unit == "%" ? 100 : 0) - value;
    case Better::kOne:
      return std::abs(value - (kind.unit == "%" ? 100 : 1));
    case Better::kLower:
      break;
  }
  return kind.statistic == Statistic::kRootMeanSquare ? std::abs(value) : value;
}

std::vector<WorstFrame> worst_frames(const std::vector<Series>& series, std::size_t of_each) {
  struct Candidate {
    const Series* series = nullptr;
    Sample sample;
    double bad = 0;
  };
  std::vector<WorstFrame> out;
  std::vector<std::string> groups;
  for (std::size_t begin = 0; begin < series.size();) {
    // Series of one kind stand together.
    std::size_t end = begin;
    while (end < series.size() && series[end].kind.group == series[begin].kind.group &&
           series[end].kind.score == series[begin].kind.score) {
      ++end;
    }
    std::vector<Candidate> candidates;
    for (std::size_t i = begin; i < end; ++i) {
      if (series[i].subject == "all" && end - begin > 1) continue;
      Candidate worst;
      for (const Sample& sample : series[i].samples) {
        if (!std::isfinite(sample.value)) continue;
        const double bad = badness(series[i].kind, sample.value);
        if (worst.series == nullptr || bad > worst.bad) worst = {&series[i], sample, bad};
      }
      const bool perfect = series[i].kind.better == Better::kHigher && series[i].kind.unit != "%"
                               ? false
                               : worst.bad <= 0;
      if (worst.series != nullptr && !perfect) candidates.push_back(worst);
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.bad > b.bad; });
    if (candidates.size() > of_each) candidates.resize(of_each);
    for (Candidate& c : candidates) {
      const ScoreKind& kind = c.series->kind;
      for (const Sample& sample : c.series->samples) {
        const double bad = badness(kind, sample.value);
        const bool chosen = std::any_of(out.begin(), out.end(), [&](const WorstFrame& w) {
          return w.group == kind.group && w.subject == c.series->subject && w.frame == sample.frame;
        });
        if (chosen && std::abs(bad - c.bad) <= kAsBad * std::abs(c.bad)) c.sample = sample;
      }
      WorstFrame frame{kind.group, c.series->subject, c.sample.frame, {}};
      auto known = std::find_if(out.begin(), out.end(),
                                [&](const WorstFrame& w) { return w.id() == frame.id(); });
      if (known == out.end()) known = out.insert(out.end(), std::move(frame));
      known->reasons.push_back(
          fmt::format("{} {:.{}f}{}{}", kind.score, c.sample.value, kind.decimals,
                      kind.unit.empty() ? "" : " ", kind.unit) +
          (kind.statistic == Statistic::kTotal
               ? std::string()
               : fmt::format(" (over all frames {:.{}f})", c.series->summary.mean, kind.decimals)));
    }
    if (groups.empty() || groups.back() != series[begin].kind.group) {
      groups.push_back(series[begin].kind.group);
    }
    begin = end;
  }
  const auto rank = [&](const WorstFrame& w) {
    return std::find(groups.begin(), groups.end(), w.group) - groups.begin();
  };
  std::stable_sort(out.begin(), out.end(),
                   [&](const WorstFrame& a, const WorstFrame& b) { return rank(a) < rank(b); });
  return out;
}

}  // namespace touchline::score::page
