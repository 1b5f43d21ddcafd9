"""Files for Kubernetes and AWS Batch against the descriptions that their own clients come with: no field is unknown, none has another type.

validate_tasks.py kubernetes FILE.yaml | aws-batch FILE.json
"""
import json
import sys


def kubernetes(path):
    import kubernetes_validate
    import yaml

    version = kubernetes_validate.latest_version()
    documents = list(yaml.safe_load_all(open(path)))
    for document in documents:
        kubernetes_validate.validate(document, version, strict=True)
    # An unknown field must be found, or the schema is none.
    documents[0]["spec"]["completionsMode"] = "Indexed"
    try:
        kubernetes_validate.validate(documents[0], version, strict=True)
    except kubernetes_validate.ValidationError:
        return f"the schemas of Kubernetes {version}"
    sys.exit("kubernetes-validate takes an unknown field")


def aws_batch(path):
    import botocore
    import botocore.session
    from botocore.validate import ParamValidator

    # The description of the service alone: no credentials, no call.
    shape = botocore.session.Session().get_service_model("batch").operation_model("SubmitJob").input_shape
    parameters = json.load(open(path))
    report = ParamValidator().validate(parameters, shape)
    if report.has_errors():
        sys.exit(report.generate_report())
    parameters["retryStrategy"]["attempt"] = 5
    if not ParamValidator().validate(parameters, shape).has_errors():
        sys.exit("botocore takes an unknown field")
    return f"SubmitJob of botocore {botocore.__version__}"


if __name__ == "__main__":
    by = {"kubernetes": kubernetes, "aws-batch": aws_batch}[sys.argv[1]](sys.argv[2])
    print(f"{sys.argv[1]}: valid by {by}")
