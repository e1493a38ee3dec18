#include "rali/io/containers/split_source.hpp"

#include <algorithm>

namespace rali::io {

SplitSource::SplitSource(std::string name, std::vector<Part> parts, Open open,
                         const ReadLimits& limits)
    : state_(std::move(name), limits), parts_(std::move(parts)), open_(std::move(open)) {
  for (const Part& part : parts_) bytes_all_ += part.bytes;
}

void SplitSource::note(Severity severity, std::string sentence) {
  state_.find(severity, "io.split", std::nullopt, std::move(sentence));
}

void SplitSource::set_truncated() { state_.health.truncated = true; }

Status SplitSource::start() {
  Error error{ErrorCode::kInput, "no file of the recording can be read", state_.name(), {}};
  bool any = false;
  bool counts_known = true;
  bool span_known = true;
  bool order_known = true, ordered = true;
  std::vector<std::pair<Time, Time>> spans;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (any && !parts_[i].cheap_to_open) {
      counts_known = span_known = order_known = false;
      continue;
    }
    auto part = open_(parts_[i].path);
    if (!part) {
      if (!any) error = part.error();
      continue;  // reported when it is opened
    }
    counts_known = look_into(**part) && counts_known;
    span_known = (*part)->span().has_value() && span_known;
    order_known = (*part)->in_order().has_value() && order_known;
    ordered = (*part)->in_order().value_or(true) && ordered;
    if ((*part)->span()) spans.push_back(*(*part)->span());
    state_.met_compression((*part)->health().compression);
    state_.health.unindexed = state_.health.unindexed || (*part)->health().unindexed;
    if (i == 0) first_ = std::move(*part);
    any = true;
  }
  if (!any) return tl::make_unexpected(error);
  if (!span_known) span_.reset();
  ordered = ordered && spans_in_order(spans);
  if (!ordered || (order_known && span_known)) in_order_ = ordered;
  if (!counts_known) state_.forget_counts();
  before_ = state_.health;
  return {};
}

/// Adds a part's topics, counts and span; false if it has no counts.
bool SplitSource::look_into(MessageSource& part) {
  bool known = true;
  for (const Topic& topic : part.topics()) {
    Topic copy = topic;
    copy.messages.reset();
    const auto index = state_.topic(std::move(copy));
    known = known && topic.messages.has_value();
    if (index && topic.messages) state_.add_count(*index, *topic.messages);
  }
  if (const auto span = part.span()) {
    if (!span_) span_ = span;
    span_->first = std::min(span_->first, span->first);
    span_->second = std::max(span_->second, span->second);
  }
  return known;
}

void SplitSource::select(std::function<bool(const Topic&)> keep) {
  keep_ = std::move(keep);
  state_.select(keep_);
}

double SplitSource::progress() const {
  if (done_ || bytes_all_ == 0) return 1.0;
  double bytes = static_cast<double>(bytes_done_);
  if (current_) {
    bytes += current_->progress() * static_cast<double>(parts_[next_part_ - 1].bytes);
  }
  return std::min(1.0, bytes / static_cast<double>(bytes_all_));
}

Result<bool> SplitSource::next(RawMessage& out) {
  while (!done_) {
    if (!current_ && !open_next()) {
      done_ = true;
      break;
    }
    if (!current_) continue;
    const auto more = current_->next(out);
    merge_health();
    if (!more) return more;
    if (!*more) {
      before_ = state_.health;
      bytes_done_ += parts_[next_part_ - 1].bytes;
      current_.reset();
      continue;
    }
    if (out.topic >= topic_of_.size()) map_topics();
    if (!topic_of_[out.topic]) continue;
    out.topic = *topic_of_[out.topic];
    return true;
  }
  return false;
}

/// Opens the next part; false after the last. An unreadable part is left out with a finding, and
/// current_ stays empty.
bool SplitSource::open_next() {
  if (next_part_ == parts_.size()) return false;
  const Part& part = parts_[next_part_++];
  auto source =
      first_ ? Result<std::unique_ptr<MessageSource>>(std::move(first_)) : open_(part.path);
  first_.reset();
  if (!source) {
    Finding finding;
    finding.id = "io.split";
    finding.severity = Severity::kError;
    finding.text = source.error().message();
    finding.effect = "this file of the recording is left out";
    state_.health.findings.push_back(std::move(finding));
    before_ = state_.health;
    bytes_done_ += part.bytes;
    return true;
  }
  current_ = std::move(*source);
  if (keep_) current_->select(keep_);
  topic_of_.clear();
  map_topics();
  return true;
}

void SplitSource::map_topics() {
  const std::vector<Topic>& topics = current_->topics();
  for (std::size_t i = topic_of_.size(); i < topics.size(); ++i) {
    Topic copy = topics[i];
    copy.messages.reset();
    topic_of_.push_back(state_.topic(std::move(copy)));
  }
}

/// Sums the health of the parts already read and the current one.
void SplitSource::merge_health() {
  const SourceHealth& part = current_->health();
  SourceHealth& all = state_.health;
  all.messages = before_.messages + part.messages;
  all.messages_skipped = before_.messages_skipped + part.messages_skipped;
  all.bytes_lost = before_.bytes_lost + part.bytes_lost;
  all.truncated = before_.truncated || part.truncated;
  all.unindexed = before_.unindexed || part.unindexed;
  if (!part.compression.empty()) state_.met_compression(part.compression);
  if (all.findings.size() == before_.findings.size() + part.findings.size()) return;
  all.findings = before_.findings;
  all.findings.insert(all.findings.end(), part.findings.begin(), part.findings.end());
}

}  // namespace rali::io
