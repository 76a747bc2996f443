// A computed-torque controller of ros2_control (Jazzy and later) around my_robot.h, which gd-analyze exported.
// Untried: the calls are those of the documentation. Before Jazzy, get_value() stands for get_optional().value(), and
// set_value returns nothing.
#include <controller_interface/controller_interface.hpp>
#include <my_robot.h>

using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;
static const std::vector<std::string> joints = {"shoulder", "elbow", "wrist"};  // as in the header of my_robot.h

InterfaceConfiguration MyController::command_interface_configuration() const
{
    InterfaceConfiguration wanted{interface_configuration_type::INDIVIDUAL, {}};
    for (const auto &joint : joints)
        wanted.names.push_back(joint + "/effort");
    return wanted;  // state_interface_configuration: joint + "/position", joint + "/velocity"
}

controller_interface::return_type MyController::update(const rclcpp::Time &, const rclcpp::Duration &)
{
    double q[my_robot_joints], qd[my_robot_joints], a[my_robot_joints], tau[my_robot_joints];
    for (int j = 0; j < my_robot_joints; j++) {
        q[j] = state_interfaces_[2 * j].get_optional().value();
        qd[j] = state_interfaces_[2 * j + 1].get_optional().value();
        a[j] = qdd_d_[j] + 40.0 * (qd_d_[j] - qd[j]) + 400.0 * (q_d_[j] - q[j]);  // the motion wanted
    }
    my_robot_torque(q, qd, a, tau);
    for (int j = 0; j < my_robot_joints; j++)
        if (!command_interfaces_[j].set_value(tau[j]))
            return controller_interface::return_type::ERROR;
    return controller_interface::return_type::OK;
}
