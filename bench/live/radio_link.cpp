// Network namespaces with an emulated radio between them, for programs that are started from
// outside (missions.py). Prints the file of each namespace, then reads commands, one per line:
//   all LOSS DELAY_S BYTES_PER_S   every link, 0 bytes/s: no limit
//   cut FROM TO | join FROM TO     one direction, vehicles count from 0
//   traffic                        prints FROM TO FRAMES_IN FRAMES_OUT BYTES_OUT per link, then "."
// The namespaces end with stdin.
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "common/command_line.hpp"
#include "net/emulated_radio.hpp"

namespace rali::bench {
namespace {

class Links {
 public:
  Links(net::EmulatedRadio& radio, std::size_t vehicles)
      : radio_(radio), vehicles_(vehicles), models_(vehicles * vehicles) {}

  /// @return false: no such command
  bool obey(const std::string& line) {
    std::istringstream words(line);
    std::string verb;
    words >> verb;
    if (verb == "all") return set_all(words);
    if (verb == "traffic") return print_traffic();
    std::size_t from = 0, to = 0;
    if ((verb != "cut" && verb != "join") || !(words >> from >> to)) return false;
    if (from >= vehicles_ || to >= vehicles_) return false;
    net::LinkModel& model = models_[from * vehicles_ + to];
    model.cut = verb == "cut";
    radio_.set(from, to, model);
    return true;
  }

 private:
  bool set_all(std::istream& words) {
    net::LinkModel model;
    if (!(words >> model.loss >> model.delay_s >> model.bytes_per_s)) return false;
    for (net::LinkModel& one : models_) one = model;
    radio_.set_all(model);
    return true;
  }

  bool print_traffic() const {
    for (std::size_t from = 0; from < vehicles_; ++from) {
      for (std::size_t to = 0; to < vehicles_; ++to) {
        if (from == to) continue;
        const net::EmulatedRadio::Traffic t = radio_.traffic(from, to);
        std::cout << from << ' ' << to << ' ' << t.frames_in << ' ' << t.frames_out << ' '
                  << t.bytes_out << '\n';
      }
    }
    std::cout << '.' << std::endl;
    return true;
  }

  net::EmulatedRadio& radio_;
  std::size_t vehicles_;
  std::vector<net::LinkModel> models_;
};

int serve(std::size_t vehicles) {
  std::string why_not;
  const std::unique_ptr<net::EmulatedRadio> radio = net::EmulatedRadio::create(vehicles, why_not);
  if (!radio) {
    std::cerr << "radio_link: " << why_not << '\n';
    return 4;
  }
  for (std::size_t v = 0; v < vehicles; ++v) std::cout << radio->space(v) << '\n';
  std::cout << std::flush;
  radio->start();
  Links links(*radio, vehicles);
  for (std::string line; std::getline(std::cin, line);) {
    if (links.obey(line)) continue;
    std::cerr << "radio_link: no command: " << line << '\n';
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace rali::bench

int main(int argc, char** argv) {
  CLI::App app("Network namespaces with an emulated radio between them");
  std::size_t vehicles = 3;
  app.add_option("--vehicles", vehicles, "namespaces")->check(CLI::Range(1, 20));
  if (const std::optional<int> code = rali::bench::ended_by(app, argc, argv)) return *code;
  return rali::bench::serve(vehicles);
}
