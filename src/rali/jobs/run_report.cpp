#include "rali/jobs/run_report.hpp"

#include "rali/drive/output/out_dir.hpp"
#include "rali/report/report.hpp"

namespace rali::jobs {

Status add_report(const std::string& out_dir) {
  const Status status = report::write_report(out_dir, out_dir + "/report.html");
  if (!status) return status;
  return drive::add_to_status(out_dir, "report.html", report::kSpeedStart, report::kSpeedEnd);
}

}  // namespace rali::jobs
