#include "rali/cli/commands/report.hpp"

#include "rali/io/files/old_names.hpp"
#include "rali/jobs/run_report.hpp"
#include "rali/report/report.hpp"

namespace rali::cli {
namespace {

class ReportCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "report"; }

  [[nodiscard]] std::string summary() const override {
    return "build report.html of a run again, or set runs side by side";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali report out", "rali report out out_paper -o compare.html"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 done, 2 no output folder of rali map, 4 disk";
  }

  [[nodiscard]] Positional positional() override {
    return {"DIR", "output folders of rali map; two or more are compared", &folders_, 1, 16, {}};
  }

  [[nodiscard]] std::vector<Option> options() override {
    return {{"-o,--out",
             "FILE",
             "the page (default DIR/report.html, of several comparison.html)",
             &file_,
             false,
             {}}};
  }

  [[nodiscard]] Result<int> run(Session& session) override {
    warn_of_old_names(folders_, session);
    const Status status = folders_.size() > 1 ? compare() : rebuild();
    if (!status) return tl::make_unexpected(status.error());
    session.result(file_ + '\n');
    return kExitDone;
  }

 private:
  [[nodiscard]] Status compare() {
    if (file_.empty()) file_ = "comparison.html";
    return report::write_comparison(folders_, file_);
  }

  [[nodiscard]] Status rebuild() {
    if (!file_.empty()) return report::write_report(folders_.front(), file_);
    file_ = folders_.front() + "/report.html";
    return jobs::add_report(folders_.front());
  }

  std::vector<std::string> folders_;
  std::string file_;
};

}  // namespace

void warn_of_old_names(const std::vector<std::string>& folders, Session& session) {
  for (const std::string& folder : folders) {
    for (const std::string& notice : io::notices_of_old_names(folder)) {
      session.warning(printable(notice) + '.');
    }
  }
}

std::unique_ptr<Command> make_report_command() { return std::make_unique<ReportCommand>(); }

}  // namespace rali::cli
