#include "rali/view/internal/answers.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace rali::view {

namespace assets {
std::string_view page();
std::string_view style();
std::string_view script();
std::string_view script_licence();
}  // namespace assets

namespace {

using nlohmann::json;

constexpr std::string_view kJson = "application/json";
constexpr std::array<std::string_view, 3> kOrders = {"end-round", "assume-lost", "finish"};

HttpAnswer text(std::string_view type, std::string body, int status = 200) {
  return {status, type, std::make_shared<const std::string>(std::move(body)), {}};
}

bool is_name(std::string_view name) {
  return !name.empty() && name.size() <= kVehicleNameMax &&
         std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < '\x7f'; });
}

/// A form of another site can post any text, but not with this content type.
HttpAnswer take_order(const HttpRequest& request, Published& published) {
  if (request.content_type.substr(0, kJson.size()) != kJson) {
    return refusal(415, "An order has the Content-Type application/json.");
  }
  Result<OperatorRequest> order = parse_order(request.body);
  if (!order) return refusal(400, order.error().message());
  if (published.orders.size() >= kOrdersMax) {
    return refusal(503, "Too many orders wait. Try again in a few seconds.");
  }
  published.orders.push_back(std::move(*order));
  return text(kJson, R"({"accepted":true})", 202);
}

std::string own_metrics(const Published& published) {
  return fmt::format(
      "# TYPE rali_view_viewers gauge\nrali_view_viewers {}\n"
      "# TYPE rali_view_frames_dropped_total counter\nrali_view_frames_dropped_total {}\n",
      published.viewers, published.frames_dropped);
}

HttpAnswer get(std::string_view path, const Published& published) {
  if (path == "/") return {200, "text/html; charset=utf-8", live_page(), {}};
  if (path == "/healthz") return text(kJson, published.health, published.healthy ? 200 : 503);
  if (path == "/metrics") {
    return text("text/plain; version=0.0.4; charset=utf-8",
                published.metrics + own_metrics(published));
  }
  if (path == "/state") {
    if (published.state.empty()) return refusal(503, "There is no state yet.");
    return text(kJson, published.state);
  }
  if (path == "/licences") {
    return text("text/plain; charset=utf-8", std::string(assets::script_licence()));
  }
  return refusal(404, "Here are /, /state, /healthz, /metrics, /operator and /licences.");
}

/// `page` with the parts inserted at the marks; the parts themselves are not searched for marks.
std::string assembled() {
  std::string out;
  std::string_view page = assets::page();
  const std::array<std::pair<std::string_view, std::string_view>, 2> parts = {
      {{"/*STYLE*/", assets::style()}, {"/*SCRIPT*/", assets::script()}}};
  for (const auto& [mark, part] : parts) {
    const std::size_t at = page.find(mark);
    if (at == std::string_view::npos) continue;
    out.append(page.substr(0, at)).append(part);
    page.remove_prefix(at + mark.size());
  }
  return out.append(page);
}

}  // namespace

Result<OperatorRequest> parse_order(std::string_view body) {
  const auto bad = [](std::string what) {
    return fail(ErrorCode::kInput, "order", std::move(what),
                R"(Send {"command": "assume-lost", "vehicle": "v2"}, "end-round" or "finish".)");
  };
  const json order = json::parse(body, nullptr, false);
  if (!order.is_object() || !order.contains("command") || !order["command"].is_string()) {
    return bad("it is no JSON object with a 'command'");
  }
  OperatorRequest out;
  out.command = order["command"].get<std::string>();
  if (std::find(kOrders.begin(), kOrders.end(), out.command) == kOrders.end()) {
    return bad("there is no such command");
  }
  if (out.command != "assume-lost") return out;
  if (!order.contains("vehicle") || !order["vehicle"].is_string()) {
    return bad("assume-lost needs a 'vehicle'");
  }
  out.vehicle = order["vehicle"].get<std::string>();
  if (!is_name(out.vehicle)) return bad("'vehicle' is no name of a vehicle");
  return out;
}

HttpAnswer refusal(int status, std::string_view sentence) {
  return text("text/plain; charset=utf-8", std::string(sentence) + '\n', status);
}

HttpAnswer answer(const HttpRequest& request, Published& published) {
  if (request.path == "/operator") {
    if (request.method == "POST") return take_order(request, published);
    HttpAnswer out = refusal(405, "Orders are sent by POST.");
    out.allow = "POST";
    return out;
  }
  if (request.method == "GET" || request.method == "HEAD") return get(request.path, published);
  HttpAnswer out = refusal(405, "Only GET is answered here.");
  out.allow = "GET, HEAD";
  return out;
}

const std::shared_ptr<const std::string>& live_page() {
  static const auto page = std::make_shared<const std::string>(assembled());
  return page;
}

}  // namespace rali::view
