"""Starts limpid as a node: no ROS package is needed, only the program in the PATH."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("config", description="limpid's parameters; `limpid config --robot` prints a file to start from"),
        DeclareLaunchArgument("namespace", default_value="/"),
        ExecuteProcess(
            cmd=[
                "limpid", "node", "-c", LaunchConfiguration("config"),
                "--ros-args", "-r", "__node:=limpid", "-r", ["__ns:=", LaunchConfiguration("namespace")],
            ],
            output="screen",
            sigterm_timeout="2",
        ),
    ])
