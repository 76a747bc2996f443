// Pinocchio as its C++ users call it: an arm put together from numbers; its torque, or D, C and c, at many states.
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>

#include <string>

namespace pin = pinocchio;
using Vector = Eigen::Map<const Eigen::VectorXd>;
using Three = Eigen::Map<const Eigen::Vector3d>;
using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct Arm {
    pin::Model model;
    pin::Data data;
};

// Per joint: rotation and translation of its placement, its axis, mass, centre of mass, inertia about it, rotor.
enum { numbers_per_joint = 29 };

extern "C" void *make(int n, const double *gravity, const double *numbers)
{
    pin::Model model;
    model.gravity.linear() = Three(gravity);
    pin::JointIndex parent = 0;
    for (int i = 0; i < n; i++, numbers += numbers_per_joint) {
        const pin::SE3 placement(Rows(Eigen::Map<const Rows>(numbers)), Three(numbers + 9));
        const Eigen::Vector3d axis = Three(numbers + 12);
        const std::string name = std::to_string(i + 1);
        // About z as a URDF reader makes it: cheaper than any other axis.
        if (axis == Eigen::Vector3d::UnitZ())
            parent = model.addJoint(parent, pin::JointModelRZ(), placement, name);
        else
            parent = model.addJoint(parent, pin::JointModelRevoluteUnaligned(axis), placement, name);
        const Rows tensor = Eigen::Map<const Rows>(numbers + 19);
        pin::Inertia body = pin::Inertia::Zero();
        body.mass() = numbers[15];
        body.lever() = Three(numbers + 16);
        body.inertia() = pin::Symmetric3(Eigen::Matrix3d(tensor));
        model.appendBodyToJoint(parent, body);
        model.armature[i] = numbers[28];
    }
    return new Arm{model, pin::Data(model)};
}

extern "C" void all(
    void *made, long passes, long count, const double *q, const double *qd, const double *qdd, double *tau)
{
    Arm &arm = *static_cast<Arm *>(made);
    const int n = arm.model.nv;
    for (long p = 0; p < passes; p++)
        for (long at = 0; at < count * n; at += n)
            Eigen::Map<Eigen::VectorXd>(tau + at, n) =
                pin::rnea(arm.model, arm.data, Vector(q + at, n), Vector(qd + at, n), Vector(qdd + at, n));
}

// Mass matrix (its upper half), Coriolis matrix and gravity loading, one after another for each state.
extern "C" void elements(void *made, long count, const double *q, const double *qd, double *out)
{
    Arm &arm = *static_cast<Arm *>(made);
    const int n = arm.model.nv;
    for (long at = 0; at < count * n; at += n) {
        Eigen::Map<Eigen::MatrixXd>(out, n, n) = pin::crba(arm.model, arm.data, Vector(q + at, n));
        out += n * n;
        Eigen::Map<Eigen::MatrixXd>(out, n, n) =
            pin::computeCoriolisMatrix(arm.model, arm.data, Vector(q + at, n), Vector(qd + at, n));
        out += n * n;
        Eigen::Map<Eigen::VectorXd>(out, n) =
            pin::computeGeneralizedGravity(arm.model, arm.data, Vector(q + at, n));
        out += n;
    }
}
