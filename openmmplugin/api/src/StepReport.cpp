#include "ragdoll/StepReport.h"

#include "BinaryStream.h"  // writeValue, readValue
#include "TextArray.h"     // TextWriter, TextReader

namespace ragdoll {

void StepReport::writeTo(OpenMM::SerializationNode& node) const {
  node.setLongProperty("iterations", iterations);
  node.setLongProperty("barVisits", barVisits);
  node.setBoolProperty("converged", converged);
  node.setDoubleProperty("residual", residual);
  node.setDoubleProperty("residualLength", residualLength);
  node.setBoolProperty("accepted", accepted);
  node.setIntProperty("invertedCentres", invertedCentres);
  node.setStringProperty("stopReason", stopReason);
  // it quotes labels of joints, which may be any text
  node.setStringProperty("worstConstraint", TextWriter().add(worstConstraint).text());
  node.setStringProperty("solver", solver);
}

StepReport StepReport::readFrom(const OpenMM::SerializationNode& node) {
  StepReport report;
  report.iterations = node.getLongProperty("iterations");
  report.barVisits = node.getLongProperty("barVisits");
  report.converged = node.getBoolProperty("converged");
  report.residual = node.getDoubleProperty("residual");
  report.residualLength = node.getDoubleProperty("residualLength", report.residualLength);
  report.accepted = node.getBoolProperty("accepted");
  report.invertedCentres = node.getIntProperty("invertedCentres");
  report.stopReason = node.getStringProperty("stopReason");
  report.worstConstraint =
      TextReader(node.getStringProperty("worstConstraint"), "worstConstraint").label();
  report.solver = node.getStringProperty("solver", report.solver);
  return report;
}

void StepReport::writeTo(std::ostream& stream) const {
  writeValue(stream, iterations);
  writeValue(stream, barVisits);
  writeValue(stream, converged);
  writeValue(stream, residual);
  writeValue(stream, residualLength);
  writeValue(stream, accepted);
  writeValue(stream, invertedCentres);
  writeText(stream, stopReason);
  writeText(stream, worstConstraint);
  writeText(stream, solver);
}

StepReport StepReport::readFrom(std::istream& stream) {
  StepReport report;
  report.iterations = readValue<long long>(stream);
  report.barVisits = readValue<long long>(stream);
  report.converged = readValue<bool>(stream);
  report.residual = readValue<double>(stream);
  report.residualLength = readValue<double>(stream);
  report.accepted = readValue<bool>(stream);
  report.invertedCentres = readValue<int>(stream);
  report.stopReason = readText(stream);
  report.worstConstraint = readText(stream);
  report.solver = readText(stream);
  return report;
}

}  // namespace ragdoll
